// The least that uses saccade::detectors.
#include <saccade/core/detectors/built_in_detectors.h>

#include <cstdio>

int main() { std::printf("detectors: %zu kinds of detectors\n", saccade::built_in_detectors().names().size()); }
