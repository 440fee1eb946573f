// Any bytes as a recording: read to its end they give events or an InputError, nothing else.
// usage: recording_fuzz --format=NAME [--write-seed=FOLDER] libFuzzer's arguments. NAME is one of small_files(); the first
// bytes of that file, which tell the codec, are put over those of every input.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/error.h"
#include "recording/event_file.h"
#include "tests/recording/small_files.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

constexpr std::size_t mark_bytes = 12;

const TempFolder& folder() {
  static const TempFolder folder;
  return folder;
}

std::string& format() {
  static std::string name;
  return name;
}
std::string& mark() {
  static std::string bytes;
  return bytes;
}

[[noreturn]] void usage() {
  std::fprintf(stderr, "usage: recording_fuzz --format=NAME [--write-seed=FOLDER] ..., NAME one of\n");
  for (const SmallFile& file : small_files()) std::fprintf(stderr, "%s\n", file.name.c_str());
  std::exit(2);
}

void read_whole(const std::filesystem::path& path, std::size_t block) {
  try {
    const auto reader = open_event_file(path);
    std::vector<Event> events;
    while (reader->read(events, block) > 0) events.clear();
    (void)reader->format();
    (void)reader->image_size();
    (void)reader->skipped();
  } catch (const InputError&) {
  }
}

}  // namespace
}  // namespace saccade

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  using namespace saccade;
  constexpr const char* format_key = "--format=";
  constexpr const char* seed_key = "--write-seed=";
  std::string seeds;
  char** kept = *argv;
  for (char** arg = *argv; arg != *argv + *argc; ++arg) {
    if (std::strncmp(*arg, format_key, std::strlen(format_key)) == 0) {
      format() = *arg + std::strlen(format_key);
    } else if (std::strncmp(*arg, seed_key, std::strlen(seed_key)) == 0) {
      seeds = *arg + std::strlen(seed_key);
    } else {
      *kept++ = *arg;
    }
  }
  *argc = static_cast<int>(kept - *argv);
  const auto files = small_files();
  const auto file =
      std::find_if(files.begin(), files.end(), [](const auto& f) { return f.name == format(); });
  if (file == files.end()) usage();
  mark() = file->bytes().substr(0, mark_bytes);
  if (!seeds.empty())
    std::ofstream(std::filesystem::path(seeds) / format(), std::ios::binary) << file->bytes();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace saccade;
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size >= mark().size()) bytes.replace(0, mark().size(), mark());
  read_whole(folder().write(format(), bytes), 1 + size % 500);
  return 0;
}
