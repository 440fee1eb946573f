// The program itself, as a library: the place where a row of one's own is added to the registry (docs/extending.md).
#include <saccade/apps/cli/program.h>

int main(int argc, char** argv) { return saccade::program(argc, argv, saccade::built_in_registry()); }
