// Any bytes as a recording: read to its end they give events or an InputError, nothing else.
// usage: recording_fuzz --list | --format=NAME [--write-seed=FOLDER] libFuzzer's arguments. NAME is one of the list: a
// handmade file of tests/recording/small_files.h, or `written` with the extension of a format that is written. The first bytes
// of that file, which the format is recognised by, replace those of every input.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/error.h"
#include "recording/format_registry.h"
#include "recording/other_records.h"
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

struct Seed {
  std::string name;
  std::string bytes;
};

/// A seed of every format that is read in this process.
std::vector<Seed> seeds() {
  std::vector<Seed> all;
  for (const SmallFile& file : small_files()) all.push_back({file.name, file.bytes()});
  const FormatRegistry registry = built_in_formats();  // the formats live as long as it
  for (const RecordingFormat& format : registry.formats()) {
    if (!format.create || format.read_in_helper) continue;
    const std::string name = "written" + format.extensions.front();
    const auto writer = format.create(folder() / name, {128, 128}, 1);
    writer->write(std::vector<Event>{{10, 1, 2, true, 0}, {20, 3, 4, false, 0}, {1020, 127, 127, true, 0}});
    writer->commit();
    all.push_back({name, bytes_of(folder() / name)});
  }
  return all;
}

[[noreturn]] void list_seeds(int status) {
  std::FILE* out = status == 0 ? stdout : stderr;
  if (status != 0)
    std::fprintf(out, "usage: recording_fuzz --format=NAME [--write-seed=FOLDER] ..., NAME one of\n");
  for (const Seed& seed : seeds()) std::fprintf(out, "%s\n", seed.name.c_str());
  std::exit(status);
}

/// Wants everything.
class AnyRecords final : public OtherRecords {
 public:
  bool wants_frames() const override { return true; }
  bool wants_inertial() const override { return true; }
  bool wants_triggers() const override { return true; }
  void add(const RecordedFrame& frame) override {
    for (const std::byte byte : frame.pixels) sum += std::to_integer<unsigned>(byte);
  }
  void add(const InertialReading& reading) override { sum += reading.source.size(); }
  void add(const RecordedTrigger& trigger) override { sum += text_of(trigger.kind).size(); }

  std::size_t sum = 0;
};

void read_whole(const std::filesystem::path& path, std::size_t block) {
  try {
    AnyRecords others;
    EventReadOptions options;
    options.others = &others;
    const auto reader = open_event_file(path, options);
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
  std::string seed_folder;
  char** kept = *argv;
  for (char** arg = *argv; arg != *argv + *argc; ++arg) {
    if (std::strcmp(*arg, "--list") == 0) list_seeds(0);
    if (std::strncmp(*arg, format_key, std::strlen(format_key)) == 0) {
      format() = *arg + std::strlen(format_key);
    } else if (std::strncmp(*arg, seed_key, std::strlen(seed_key)) == 0) {
      seed_folder = *arg + std::strlen(seed_key);
    } else {
      *kept++ = *arg;
    }
  }
  *argc = static_cast<int>(kept - *argv);
  const std::vector<Seed> all = seeds();
  const auto seed = std::find_if(all.begin(), all.end(), [](const Seed& s) { return s.name == format(); });
  if (seed == all.end()) list_seeds(2);
  mark() = seed->bytes.substr(0, mark_bytes);
  if (!seed_folder.empty()) {
    std::ofstream(std::filesystem::path(seed_folder) / format(), std::ios::binary) << seed->bytes;
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace saccade;
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size >= mark().size()) bytes.replace(0, mark().size(), mark());
  read_whole(folder().write(format(), bytes), 1 + size % 500);
  return 0;
}
