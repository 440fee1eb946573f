#include "apps/cli/program.h"

int main(int argc, char** argv) { return saccade::program(argc, argv, saccade::built_in_registry()); }
