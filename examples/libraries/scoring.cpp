// The least that uses saccade::scoring.
#include <saccade/evaluation/scoring/statistics.h>

#include <cstdio>

int main() { std::printf("scoring: the median is %g\n", *saccade::percentiles_of({1.0, 2.0, 4.0}).median); }
