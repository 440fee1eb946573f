#include "recording/recorded_folder.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <system_error>
#include <tuple>

#include "core/error.h"
#include "recording/conversion.h"
#include "recording/number_text.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view part_ending = ".part";

/// The name that the file has when it is finished.
fs::path finished_name(const fs::path& path) {
  return path.extension() == part_ending ? fs::path(path).replace_extension() : path;
}

/// What the name of a file in the folder of a run says; none for a file that is neither events nor a table.
std::optional<RecordedFile> described(const FormatRegistry& formats, const fs::path& path) {
  const fs::path name = finished_name(path).filename();
  const std::string stem = name.stem().string();
  RecordedFile file;
  file.path = path;
  file.unfinished = path.extension() == part_ending;
  const std::size_t line = stem.rfind('_');
  const char* const end = stem.data() + stem.size();
  if (line != std::string::npos) {
    const auto number = std::from_chars(stem.data() + line + 1, end, file.number);
    if (number.ec != std::errc() || number.ptr != end) file.number = 1;
  }
  const std::string extension = name.extension().string();
  const auto has_extension = [&](const RecordingFormat& format) {
    return format.create && std::ranges::count(format.extensions, extension) > 0;
  };
  const bool is_rotated = stem == "events" || (stem.starts_with("events_") && file.number > 1);
  file.has_events = is_rotated && std::ranges::any_of(formats.formats(), has_extension);
  if (!file.has_events && extension != ".csv") return std::nullopt;
  return file;
}

void inspect_events(const FormatRegistry& formats, const EventReadOptions& options,
                    const std::function<void(std::int64_t)>& progress, RecordedFile& file) {
  constexpr std::int64_t no_gap_us = std::numeric_limits<std::int64_t>::max();
  try {
    const RecordingSummary summary = summarise_recording(formats, file.path, options, no_gap_us, progress);
    const EventStatistics& events = summary.counter.all();
    file.rows = events.count;
    if (events.count > 0) {
      file.first_us = events.oldest_us;
      file.last_us = events.newest_us;
    }
    file.torn = summary.torn;
  } catch (const InputError& error) {
    file.unreadable = error.what();
  }
}

/// A table is whole up to the first line without an end, with another number of fields, or without a time in front.
void inspect_table(RecordedFile& file) {
  std::ifstream in(file.path, std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || in.eof() || !without_mark(line).starts_with("t_us,")) {
    file.unreadable = "no first line with the names of columns";
    return;
  }
  const auto columns = std::ranges::count(line, ',');
  std::uint64_t byte = line.size() + 1;
  for (std::int64_t number = 2; std::getline(in, line); ++number) {
    std::int64_t t_us = 0;
    const bool ends = !in.eof();
    const bool is_row = std::ranges::count(line, ',') == columns &&
                        parse_number(std::string_view(line).substr(0, line.find(',')), t_us) &&
                        line.find('\0') == std::string::npos;
    if (!ends || !is_row) {
      const std::uint64_t size = fs::file_size(file.path);
      file.torn = TornEnd{byte, size - std::min(byte, size),
                          "line " + std::to_string(number) + (ends ? " is no row" : " has no end"), !ends};
      return;
    }
    byte += line.size() + 1;
    ++file.rows;
    file.first_us = std::min(file.first_us.value_or(t_us), t_us);
    file.last_us = std::max(file.last_us.value_or(t_us), t_us);
  }
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(error)) paths.push_back(entry.path());
  if (error) throw InputError(folder.string(), error.message(), "a folder");
  return paths;
}

}  // namespace

bool has_parts(const FormatRegistry& formats, const fs::path& folder) {
  return std::ranges::any_of(files_in(folder), [&](const fs::path& path) {
    const auto file = described(formats, path);
    return file && (file->unfinished || (file->has_events && file->number > 1));
  });
}

std::vector<RecordedFile> inspect_recorded(const FormatRegistry& formats, const fs::path& path,
                                           const EventReadOptions& options,
                                           const std::function<void(std::int64_t)>& progress) {
  std::vector<RecordedFile> files;
  if (fs::is_directory(path)) {
    const auto add = [&](const fs::path& folder, bool may_have_events) {
      for (const fs::path& one : files_in(folder)) {
        auto file = described(formats, one);
        if (!file) continue;
        file->has_events = file->has_events && may_have_events;
        files.push_back(std::move(*file));
      }
    };
    add(path, true);
    if (fs::is_directory(path / "blackbox")) add(path / "blackbox", false);
  } else {
    RecordedFile file;
    file.path = path;
    file.unfinished = path.extension() == part_ending;
    std::string first;
    std::getline(std::ifstream(path), first);
    const std::string_view line = without_mark(first);
    file.has_events = !line.starts_with("t_us,") || line == "t_us,x,y,p" || line == "t_us,x,y,p,camera";
    files.push_back(std::move(file));
  }
  std::ranges::sort(files, {}, [](const RecordedFile& file) {
    const fs::path name = finished_name(file.path);
    return std::tuple(!file.has_events, file.path.parent_path(), file.has_events ? "" : name.stem().string(),
                      file.number, file.path);
  });
  const RecordedFile* before = nullptr;
  for (RecordedFile& file : files) {
    if (!file.has_events) {
      inspect_table(file);
      continue;
    }
    inspect_events(formats, options, progress, file);
    if (!file.first_us) continue;
    if (before != nullptr) file.after_gap_us = *file.first_us - *before->last_us;
    before = &file;
  }
  return files;
}

fs::path write_whole_part(const FormatRegistry& formats, const RecordedFile& file,
                          const EventReadOptions& options) {
  if (!file.unreadable.empty())
    throw InputError(file.path.string(), file.unreadable, "a file with a whole part");
  fs::path out = finished_name(file.path);
  if (fs::exists(out)) out.replace_filename(out.stem().string() + "_whole" + out.extension().string());
  check_outputs(std::vector{out}, {}, false);
  // The writer's own .part file would be the one that is read.
  const fs::path other = out.parent_path() / (out.stem().string() + "_repair" + out.extension().string());
  if (file.has_events) {
    ConversionConfig config;
    config.read = options;
    config.whole_part = true;
    convert_recording(formats, file.path, other, config);
  } else {
    std::ifstream in(file.path, std::ios::binary);
    OutputFile copy(other);
    std::uint64_t left = file.torn ? file.torn->byte : fs::file_size(file.path);
    for (std::string block(std::size_t{1} << 16, '\0'); left > 0 && in;) {
      in.read(block.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(block.size(), left)));
      copy.write(std::string_view(block.data(), static_cast<std::size_t>(in.gcount())));
      left -= static_cast<std::uint64_t>(in.gcount());
    }
    if (left > 0) throw RunError(file.path.string() + ": cannot be read");
    copy.commit();
  }
  const std::vector<fs::path> from = formats.inputs_of(other);
  const std::vector<fs::path> to = formats.inputs_of(out);
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::error_code error;
    if (i > 0 && !fs::exists(from[i])) continue;  // a companion that this recording does not have
    fs::rename(from[i], to[i], error);
    if (error) throw RunError(to[i].string() + ": " + error.message());
  }
  return out;
}

}  // namespace saccade
