// The program `saccade` with one more format of recordings, `*.packed`.
#include "apps/cli/program.h"
#include "packed_format.h"

int main(int argc, char** argv) {
  saccade::Registry registry = saccade::built_in_registry();
  registry.formats.add(example::packed_format());
  return saccade::program(argc, argv, registry);
}
