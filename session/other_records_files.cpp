#include "session/other_records_files.h"

#include <fmt/format.h>

#include <array>
#include <opencv2/core.hpp>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "evaluation/image_codecs/image_codecs.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view table_name = "frames.csv";

void check_folder(const fs::path& folder, bool force) {
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  if (!force)
    throw InputError(folder.string(), "a folder that exists", "another name, or --force to replace it");
  if (!fs::exists(folder / table_name, error))
    throw InputError(folder.string(), "a folder without " + std::string(table_name),
                     "a folder of frames to replace, or another name");
}

[[noreturn]] void fail(const fs::path& path, const std::error_code& error) {
  throw RunError(path.string() + ": " + error.message());
}

/// Without a fourth channel: that of a camera says nothing.
cv::Mat image_of(const RecordedFrame& frame) {
  const int depth = frame.bits == 16 ? CV_16U : CV_8U;
  // The pixels are read alone: cv::Mat has no form for that.
  cv::Mat pixels(frame.height, frame.width, CV_MAKETYPE(depth, frame.channels),
                 const_cast<std::byte*>(frame.pixels.data()));
  if (frame.channels != 4) return pixels;
  cv::Mat colour(frame.height, frame.width, CV_MAKETYPE(depth, 3));
  cv::mixChannels(pixels, colour, {0, 0, 1, 1, 2, 2});
  return colour;
}

std::string text_or_empty(const std::optional<std::int64_t>& time) {
  return time ? std::to_string(*time) : std::string();
}

/// A field of a table; quoted where it has a character that separates fields.
std::string field(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

OtherRecordsFiles::OtherRecordsFiles(const fs::path& out, std::string_view kinds, bool force) {
  const auto beside = [&](std::string_view ending) {
    return out.parent_path() / (out.stem().string() + std::string(ending));
  };
  const std::array<std::pair<std::string_view, Kind*>, 3> all = {
      {{"frames", &frames_}, {"imu", &imu_}, {"triggers", &triggers_}}};
  for (std::string_view rest = kinds; !rest.empty();) {
    const std::string_view word = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    const auto known = std::ranges::find(all, word, &std::pair<std::string_view, Kind*>::first);
    if (known == all.end()) throw InputError("--also", std::string(kinds), "some of frames,imu,triggers");
    known->second->wanted = true;
    known->second->path = beside(word == "frames" ? ".frames" : "." + std::string(word) + ".csv");
  }
  for (const Kind* table : {&imu_, &triggers_})
    if (table->wanted) check_outputs(std::array{table->path}, {}, force);
  if (frames_.wanted) check_folder(frames_.path, force);
  frames_part_ = frames_.path;
  frames_part_ += ".part";
}

OtherRecordsFiles::~OtherRecordsFiles() {
  frames_.table.reset();
  std::error_code error;
  if (frames_.count > 0) fs::remove_all(frames_part_, error);  // nothing there after commit()
}

OutputFile& OtherRecordsFiles::table_of(Kind& kind, const fs::path& path, std::string_view columns) {
  if (!kind.table) {
    kind.table = std::make_unique<OutputFile>(path);
    kind.table->write(columns);
  }
  return *kind.table;
}

void OtherRecordsFiles::add(const RecordedFrame& frame) {
  if (frames_.count == 0) {
    std::error_code error;
    fs::remove_all(frames_part_, error);
    if (!fs::create_directories(frames_part_, error) && error) fail(frames_part_, error);
  }
  const std::string name = fmt::format("{:06}{}", frames_.count++,
                                       frame.encoded.empty() ? std::string_view(".png") : frame.extension);
  OutputFile& table = table_of(frames_, frames_part_ / table_name, "file,t_us,begin_us,end_us,x,y,source\n");
  OutputFile image(frames_part_ / name);
  if (!frame.encoded.empty()) {
    image.write(frame.encoded);
  } else {
    image.write(std::as_bytes(std::span<const unsigned char>(encoded_image("png", image_of(frame)))));
  }
  image.commit();
  table.write(fmt::format("{},{},{},{},{},{},{}\n", name, frame.t_us, text_or_empty(frame.begin_us),
                          text_or_empty(frame.end_us), frame.x, frame.y, field(frame.source)));
}

void OtherRecordsFiles::add(const InertialReading& reading) {
  ++imu_.count;
  OutputFile& table = table_of(
      imu_, imu_.path, "t_us,wx_rad_s,wy_rad_s,wz_rad_s,ax_m_s2,ay_m_s2,az_m_s2,temperature_deg_c,source\n");
  const auto& [wx, wy, wz] = reading.angular_velocity_rad_s;
  const auto& [ax, ay, az] = reading.acceleration_m_s2;
  table.write(fmt::format("{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{},{}\n", reading.t_us, wx, wy, wz,
                          ax, ay, az,
                          reading.temperature_deg_c ? fmt::format("{:.6g}", *reading.temperature_deg_c) : "",
                          field(reading.source)));
}

void OtherRecordsFiles::add(const RecordedTrigger& trigger) {
  ++triggers_.count;
  table_of(triggers_, triggers_.path, "t_us,channel,kind,source\n")
      .write(fmt::format("{},{},{},{}\n", trigger.t_us, trigger.channel, text_of(trigger.kind),
                         field(trigger.source)));
}

std::vector<std::string> OtherRecordsFiles::commit() {
  std::vector<std::string> lines;
  const auto tell = [&](const Kind& kind, std::string_view what) {
    if (!kind.wanted) return;
    lines.push_back(kind.count > 0 ? fmt::format("{}: {} {}", kind.path.string(), kind.count, what)
                                   : fmt::format("no {} in the recording", what));
  };
  // What an earlier recording had does not stay beside this one.
  std::error_code error;
  for (const Kind* kind : {&frames_, &imu_, &triggers_})
    if (kind->table) kind->table->commit();
  for (const Kind* table : {&imu_, &triggers_})
    if (table->wanted && table->count == 0 && !fs::remove(table->path, error) && error)
      fail(table->path, error);
  if (frames_.wanted) fs::remove_all(frames_.path, error);
  if (!error && frames_.count > 0) fs::rename(frames_part_, frames_.path, error);
  if (error) fail(frames_.path, error);
  tell(frames_, "frames");
  tell(imu_, "inertial readings");
  tell(triggers_, "triggers");
  return lines;
}

}  // namespace saccade
