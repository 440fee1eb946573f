#include "images/emulation.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/config.h"
#include "core/error.h"
#include "recording/number_text.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::string_view label_header = "t_us,x,y,p,cause\n";

/// The smallest and the largest of finite numbers.
struct LuminanceRange {
  float min = std::numeric_limits<float>::infinity();
  float max = -std::numeric_limits<float>::infinity();

  void add(std::span<const float> values) {
    std::array<float, 8> least, greatest;  // lanes that the compiler takes side by side
    least.fill(min);
    greatest.fill(max);
    const auto take = [&](std::size_t lane, float value) {
      least[lane] = value < least[lane] ? value : least[lane];
      greatest[lane] = value > greatest[lane] ? value : greatest[lane];
    };
    std::size_t i = 0;
    for (; i + 8 <= values.size(); i += 8) {
      for (std::size_t lane = 0; lane < 8; ++lane) take(lane, values[i + lane]);
    }
    for (; i < values.size(); ++i) take(0, values[i]);
    min = *std::ranges::min_element(least);
    max = *std::ranges::max_element(greatest);
  }
};

/// When each image was taken: the times of a file, or k / rate to the nearest microsecond.
class ImageClock {
 public:
  ImageClock(const EmulationConfig& options, std::vector<ImageTime> times, const ImageSequenceInfo& info)
      : times_(std::move(times)) {
    if (!times_.empty()) {
      file_ = options.timestamps.string();
      if (info.count > 0 && info.count != std::ssize(times_)) complain(std::to_string(info.count));
      return;
    }
    constexpr Range rates{1e-3, 1e6};
    const std::string expectation = expectation_of(rates, "a finite number");
    if (options.images_per_s && !rates.contains(*options.images_per_s)) {
      throw InputError("--fps", text_of(*options.images_per_s), expectation);
    }
    follows_video_ = !options.images_per_s;
    const std::optional<double> rate = options.images_per_s ? options.images_per_s : info.images_per_s;
    if (!rate || !rates.contains(*rate)) {
      throw InputError(options.images.string(), "images without times", "--fps RATE or --timestamps FILE");
    }
    rate_ = *rate;
  }

  /// `video_us`: as the video's container has it. Throws InputError where the file has fewer times.
  [[nodiscard]] std::int64_t time_us(std::int64_t image, std::optional<std::int64_t> video_us) const {
    if (follows_video_ && video_us) return *video_us;
    if (times_.empty()) return std::llround(static_cast<double>(image) * 1e6 / rate_);
    if (image >= std::ssize(times_)) complain("more");
    return times_[static_cast<std::size_t>(image)].t_us;
  }
  /// Throws InputError where the file has more times.
  void check_count(std::int64_t images) const {
    if (!times_.empty() && images != std::ssize(times_)) complain(std::to_string(images));
  }

 private:
  [[noreturn]] void complain(const std::string& images) const {
    throw InputError(file_, std::to_string(times_.size()) + " times",
                     images + ", as many as there are images");
  }

  std::vector<ImageTime> times_;
  std::string file_;
  double rate_ = 0.0;
  bool follows_video_ = false;
};

/// One row per event, in the order of the event file.
class LabelWriter {
 public:
  explicit LabelWriter(const std::filesystem::path& path) : file_(path) { file_.write(label_header); }

  void write(std::span<const Event> events, std::span<const EventLabel> labels) {
    text_.clear();
    for (std::size_t i = 0; i < events.size(); ++i) {
      append_number(text_, events[i].t_us);
      text_ += ',';
      append_number(text_, events[i].x);
      text_ += ',';
      append_number(text_, events[i].y);
      text_ += events[i].on ? ",1," : ",0,";
      text_ += event_cause_names[static_cast<std::size_t>(labels[i].cause)];
      text_ += '\n';
    }
    file_.write(text_);
  }
  void commit() { file_.commit(); }

 private:
  OutputFile file_;
  std::string text_;
};

}  // namespace

EmulationResult emulate_images(const EmulationConfig& options, const FormatRegistry& formats,
                               const EmulationProgress& progress) {
  std::vector<ImageTime> times;
  if (!options.timestamps.empty()) times = read_image_times(options.timestamps, options.time_unit);
  const bool named = !times.empty() && !times.front().name.empty();
  const auto sequence = open_image_sequence(options.images, options.emulator.white,
                                            named ? times : std::span<const ImageTime>{});
  const ImageSequenceInfo& info = sequence->info();
  const ImageClock clock(options, std::move(times), info);
  EventEmulator emulator(options.emulator, info.size, static_cast<std::uint64_t>(options.seed),
                         options.threads);
  const auto writer = create_event_file(formats, options.out, info.size);
  std::optional<LabelWriter> label_writer;
  if (!options.labels.empty()) label_writer.emplace(options.labels);

  std::vector<float> image, next_image;
  std::vector<Event> events;
  std::vector<EventLabel> labels;
  std::vector<EventLabel>* const wanted_labels = label_writer ? &labels : nullptr;
  const auto write = [&] {
    writer->write(events);
    if (label_writer) label_writer->write(events, labels);
    events.clear();
    labels.clear();
  };

  LuminanceRange luminance;
  // With more than one thread the next image is read while this one is worked on.
  const std::launch policy = options.threads > 1 ? std::launch::async : std::launch::deferred;
  struct Read {
    bool done = false;
    std::optional<std::int64_t> time_us;
  };
  const auto read_next = [&] {
    return std::async(policy, [&] {
      const bool done = sequence->read(next_image);
      return Read{done, sequence->time_us()};
    });
  };
  std::future<Read> ahead = read_next();
  std::int64_t images = 0, first_us = 0, last_us = 0;
  for (Read read = ahead.get(); read.done; read = ahead.get(), ++images) {
    std::swap(image, next_image);
    ahead = read_next();
    last_us = clock.time_us(images, read.time_us);
    if (images == 0) first_us = last_us;
    try {
      emulator.process_image(image, last_us, events, wanted_labels);
    } catch (const InputError& error) {
      std::vector<Problem> problems = error.problems();
      for (Problem& problem : problems) problem.place = sequence->name_of(images) + ": " + problem.place;
      throw InputError(std::move(problems));
    }
    luminance.add(image);
    write();
    if (progress) progress(images + 1, info.count);
  }
  clock.check_count(images);
  if (images < 2) {
    throw InputError(options.images.string(), images == 1 ? "one image" : "no images", "at least two");
  }
  emulator.finish(events, wanted_labels);
  write();
  if (label_writer) label_writer->commit();
  writer->commit();
  return {info, images, first_us, last_us, luminance.min, luminance.max, emulator.counts()};
}

std::string luminance_warning(const EmulatorConfig& camera, float largest) {
  constexpr float most = 1.5F;
  if (largest > most || camera.dark_current <= 0.0 || camera.white <= static_cast<double>(most)) return {};
  std::string text = "luminance goes up to ";
  append_number(text, std::round(largest * 1e3F) / 1e3F);
  text += " and white is at ";
  append_number(text, camera.white);
  return text + "; for images in 0..1 use white=1 and dark_current=0.04";
}

}  // namespace saccade
