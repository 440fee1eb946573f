// The least that uses saccade::core.
#include <saccade/core/random.h>

#include <cstdio>

int main() { std::printf("core: %.3f\n", saccade::RandomStream(7, "example").uniform(0)); }
