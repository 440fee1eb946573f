#include "recording/format_registry.h"

#include <algorithm>
#include <cctype>

#include "core/error.h"
#include "recording/aedat2_codec.h"
#include "recording/aedat3_codec.h"
#include "recording/aedat4_codec.h"
#include "recording/codec.h"
#include "recording/dat_codec.h"
#include "recording/event_stream_codec.h"
#include "recording/evt_codec.h"
#include "recording/hdf5_codec.h"
#include "recording/input_file.h"
#include "recording/mcap_codec.h"
#include "recording/nmnist_codec.h"
#include "recording/npz_codec.h"
#include "recording/ros2_bag_codec.h"
#include "recording/ros_bag_codec.h"
#include "recording/text_codec.h"
#include "recording/yarp_log_codec.h"

namespace saccade {
FormatRegistry built_in_formats() {
  FormatRegistry registry;
  registry.add(aedat1_format());
  registry.add(aedat2_format());
  registry.add(aedat3_format());
  registry.add(aedat4_format());
  registry.add(prophesee_raw_format());
  registry.add(prophesee_dat_format());
  registry.add(event_stream_format());
  registry.add(nmnist_format());
  registry.add(hdf5_format());
  registry.add(numpy_format());
  registry.add(ros_bag_format());
  registry.add(mcap_format());
  registry.add(ros2_bag_format());
  registry.add(yarp_log_format());
  registry.add(yarp_binary_format());
  registry.add(text_format());
  return registry;
}

Match FileStart::begins_with(std::string_view mark) const {
  if (bytes.starts_with(mark)) return Match::certain;
  return mark.starts_with(bytes) ? Match::cut_off : Match::none;
}

bool FileStart::is_text() const {
  return std::all_of(bytes.begin(), bytes.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\r' || c == '\t';
  });
}

bool FileStart::has_line_without(char mark) const {
  for (std::size_t end = bytes.find('\n'); end != std::string_view::npos; end = bytes.find('\n', end + 1)) {
    if (end + 1 < bytes.size() && bytes[end + 1] != mark) return true;
  }
  return false;
}

void FormatRegistry::add(RecordingFormat format) {
  SACCADE_CHECK(!format.name.empty() && !format.extensions.empty() && format.sniff && format.open);
  for (const RecordingFormat& other : *formats_) {
    SACCADE_CHECK(other.name != format.name);
    for (const std::string& extension : format.extensions) {
      const bool taken = std::ranges::count(other.extensions, extension) > 0;
      SACCADE_CHECK(!(taken && other.create && format.create));
    }
  }
  auto longer = std::make_shared<std::vector<RecordingFormat>>(*formats_);
  longer->push_back(std::move(format));
  formats_ = std::move(longer);
}

std::string FormatRegistry::names() const {
  std::string text;
  for (std::size_t i = 0; i < formats_->size(); ++i) {
    if (i > 0) text += i + 1 == formats_->size() ? " or " : ", ";
    text += (*formats_)[i].name;
  }
  return text;
}

const RecordingFormat& FormatRegistry::recognise(const FileStart& start) const {
  const RecordingFormat* best = nullptr;
  Match match = Match::none;
  for (const RecordingFormat& format : *formats_) {
    const Match found = format.sniff(start);
    if (found <= match) continue;
    best = &format;
    match = found;
  }
  const std::string expectation = "a recording in a known format: " + names();
  if (match == Match::cut_off) {
    throw InputError(start.path.string(), "a file cut off inside its first line", expectation);
  }
  if (best == nullptr) {
    throw InputError(start.path.string(), "a file that starts with " + printable(start.bytes.substr(0, 16)),
                     expectation);
  }
  return *best;
}

const RecordingFormat& FormatRegistry::named(std::string_view name) const {
  const auto is_same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  const auto found = std::ranges::find_if(*formats_, [&](const RecordingFormat& format) {
    return std::ranges::equal(format.name, name, is_same);
  });
  if (found == formats_->end()) throw InputError("--format", std::string(name), "auto, " + names());
  return *found;
}

const RecordingFormat& FormatRegistry::for_writing(const std::filesystem::path& path) const {
  const std::string extension = path.extension().string();
  for (const RecordingFormat& format : *formats_) {
    if (format.create && std::ranges::count(format.extensions, extension) > 0) return format;
  }
  throw InputError(path.string(), extension.empty() ? "no extension" : "the extension " + extension,
                   "one of " + written_extensions());
}

std::filesystem::path FormatRegistry::file_of(const std::filesystem::path& path) const {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return path;
  for (const RecordingFormat& format : *formats_) {
    const std::string& name = format.file_in_folder;
    if (!name.empty() && std::filesystem::exists(path / name, error)) return path / name;
  }
  std::vector<std::string> marks, extensions;
  for (const RecordingFormat& format : *formats_) {
    const std::string& mark = format.folder_mark;
    if (mark.empty() || !std::filesystem::exists(path / mark, error)) continue;
    if (std::ranges::count(marks, mark) == 0) marks.push_back(mark);
    extensions.insert(extensions.end(), format.extensions.begin(), format.extensions.end());
  }
  if (marks.empty()) return path;
  std::vector<std::string> found, others;
  for (const auto& entry : std::filesystem::directory_iterator(path, error)) {
    const bool fits = std::ranges::count(extensions, entry.path().extension().string()) > 0;
    (fits ? found : others).push_back(entry.path().filename().string());
  }
  std::ranges::sort(found);
  std::ranges::sort(others);
  if (found.size() == 1) return path / found.front();
  std::string expected;
  for (const std::string& extension : extensions) expected += (expected.empty() ? "" : " or ") + extension;
  const std::string content = found.empty() ? "a folder of " + joined(others) : "a bag of " + joined(found);
  throw InputError(
      path.string(), printable(content),
      "one " + expected + " file beside " + joined(marks) +
          (found.empty() ? "; compressed ones are unpacked first" : "; each can be read by itself"));
}

std::string FormatRegistry::written_extensions(int cameras) const {
  std::vector<std::string> extensions;
  for (const RecordingFormat& format : *formats_) {
    if (!format.create || format.cameras < cameras) continue;
    extensions.insert(extensions.end(), format.extensions.begin(), format.extensions.end());
  }
  std::sort(extensions.begin(), extensions.end());
  return joined(extensions);
}

std::vector<std::string> FormatRegistry::run_choices(bool live) const {
  std::vector<std::string> choices;
  for (const RecordingFormat& format : *formats_) {
    if (!format.create || (live && format.longest_us)) continue;
    choices.push_back(format.extensions.front().substr(1));
  }
  std::sort(choices.begin(), choices.end());
  return choices;
}

std::vector<std::string> FormatRegistry::run_choices_for(ImageSize size, int cameras) const {
  std::vector<std::string> choices = run_choices();
  std::erase_if(choices, [&](const std::string& choice) {
    const RecordingFormat& format = for_writing("events." + choice);
    const ImageSize largest = format.largest_size.value_or(size);
    return cameras > format.cameras || size.width > largest.width || size.height > largest.height ||
           (cameras > 1 && format.size_of_two.value_or(size) != size);
  });
  return choices;
}

std::vector<std::filesystem::path> FormatRegistry::files_of(const std::filesystem::path& path) const {
  (void)for_writing(path);
  return inputs_of(path);
}

std::vector<std::filesystem::path> FormatRegistry::inputs_of(const std::filesystem::path& path) const {
  std::vector<std::filesystem::path> files = {path};
  for (const RecordingFormat& format : *formats_) {
    if (!format.companions || std::ranges::count(format.extensions, path.extension().string()) == 0) continue;
    for (std::filesystem::path& companion : format.companions(path)) files.push_back(std::move(companion));
  }
  return files;
}

}  // namespace saccade
