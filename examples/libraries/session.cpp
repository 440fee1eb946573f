// The least that uses saccade::session.
#include <saccade/session/version.h>

#include <cstdio>

int main() {
  std::printf("session: version %.*s\n", static_cast<int>(saccade::version().size()),
              saccade::version().data());
}
