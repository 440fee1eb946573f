// The least that uses saccade::report.
#include <saccade/evaluation/report/palette.h>

#include <cstdio>

int main() { std::printf("report: best is %s\n", saccade::hex(saccade::detector_colour("best")).c_str()); }
