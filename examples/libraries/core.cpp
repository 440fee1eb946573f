// The least that uses saccade::core.
#include <saccade/core/detector_registry.h>

#include <cstdio>

int main() { std::printf("core: %zu kinds of detectors\n", saccade::built_in_detectors().names().size()); }
