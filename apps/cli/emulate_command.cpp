#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <future>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "apps/cli/commands.h"
#include "apps/config/scenario.h"
#include "apps/images/image_sequence.h"
#include "apps/session/interrupt.h"
#include "apps/session/progress.h"
#include "emulator/event_emulator.h"
#include "recording/event_file.h"
#include "recording/input_file.h"
#include "recording/number_text.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::string_view label_header = "t_us,x,y,p,cause\n";

struct EmulateOptions {
  std::filesystem::path images, out, config, timestamps, labels;
  std::string preset;
  std::vector<std::string> assignments;
  std::optional<double> images_per_s;
  std::int64_t seed = 1;
  int threads = 2;
  bool force = false;
};

/// The least and the greatest of finite numbers.
struct Extent {
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
  ImageClock(const EmulateOptions& options, std::vector<ImageTime> times, const ImageSequenceInfo& info)
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
    const std::optional<double> rate = options.images_per_s ? options.images_per_s : info.images_per_s;
    if (!rate || !rates.contains(*rate)) {
      throw InputError(options.images.string(), "images without times", "--fps RATE or --timestamps FILE");
    }
    rate_ = *rate;
  }

  /// Throws InputError where the file has fewer times.
  [[nodiscard]] std::int64_t time_us(std::int64_t image) const {
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

bool holds_events(const std::filesystem::path& path) {
  try {
    std::vector<Event> events;
    open_event_file(path)->read(events, 1);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

bool holds_labels(const std::filesystem::path& path) {
  return InputFile(path).peek(label_header.size()).starts_with(label_header);
}

/// An earlier result may be replaced, and a file with nothing in it; anything else only where it is asked for.
template <class Holds>
void check_output(const std::filesystem::path& path, bool force, const char* kind, const Holds& is_result) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return;
  if (std::filesystem::is_directory(path, error)) {
    throw InputError(path.string(), "a folder", "the name of a file to write");
  }
  if (force || std::filesystem::file_size(path, error) == 0 || is_result(path)) return;
  throw InputError(path.string(), fmt::format("a file that holds no {}", kind),
                   "another name, or --force to replace it");
}

void print_summary(const EmulateOptions& options, const ImageSequenceInfo& info, std::int64_t images,
                   std::int64_t first_us, std::int64_t last_us, const Extent& luminance,
                   const EmulatorCounts& counts) {
  const double duration_s = static_cast<double>(last_us - first_us) * 1e-6;
  const double rate_hz = static_cast<double>(counts.events()) / duration_s;
  fmt::print("images         {}, {} x {}\n", images, info.size.width, info.size.height);
  if (info.passed_over > 0) fmt::print("passed over    {} that are no images\n", info.passed_over);
  fmt::print("time           {} us to {} us, {:.6f} s\n", first_us, last_us, duration_s);
  fmt::print("luminance      {:.6g} to {:.6g}\n", luminance.min, luminance.max);
  fmt::print("events         {}\n", counts.events());
  fmt::print("rate           {:.0f} events/s, {:.4g} per second and pixel\n", rate_hz,
             rate_hz / info.size.pixels());
  fmt::print("ON : OFF       {} : {}\n", counts.on, counts.off);
  std::string causes;
  for (std::size_t i = 0; i < event_cause_names.size(); ++i) {
    if (counts.by_cause[i] == 0) continue;
    causes += fmt::format("{}{} {}", causes.empty() ? "" : ", ", event_cause_names[i], counts.by_cause[i]);
  }
  if (!causes.empty()) fmt::print("by cause       {}\n", causes);
  fmt::print("dropped        {}\n", counts.dropped);
  fmt::print("{}\n", options.out.string());
}

int emulate(const EmulateOptions& options) {
  std::vector<std::string> assignments = options.assignments;
  if (!options.preset.empty()) assignments.insert(assignments.begin(), "preset=" + options.preset);
  const EmulatorConfig config = read_emulator(options.config, assignments);
  constexpr Range seeds{0.0, 9e15};
  if (!seeds.contains(static_cast<double>(options.seed))) {
    throw InputError("--seed", std::to_string(options.seed), expectation_of(seeds, "a whole number"));
  }
  check_output(options.out, options.force, "events", holds_events);
  if (!options.labels.empty()) {
    if (options.labels == options.out) {
      throw InputError("--labels", options.labels.string(), "another file than the events'");
    }
    check_output(options.labels, options.force, "labels", holds_labels);
  }

  std::vector<ImageTime> times;
  if (!options.timestamps.empty()) times = read_image_times(options.timestamps);
  const bool named = !times.empty() && !times.front().name.empty();
  const auto sequence =
      open_image_sequence(options.images, config.white, named ? times : std::span<const ImageTime>{});
  const ImageSequenceInfo& info = sequence->info();
  const ImageClock clock(options, std::move(times), info);
  EventEmulator emulator(config, info.size, static_cast<std::uint64_t>(options.seed), options.threads);
  catch_interrupts();
  const auto writer = create_event_file(options.out, info.size);
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

  Extent luminance;
  Progress progress(static_cast<double>(info.count));
  const auto begin = std::chrono::steady_clock::now();
  // With more than one thread the next image is read while this one is worked on.
  const std::launch policy = options.threads > 1 ? std::launch::async : std::launch::deferred;
  const auto read_next = [&] { return std::async(policy, [&] { return sequence->read(next_image); }); };
  std::future<bool> is_read = read_next();
  std::int64_t images = 0;
  for (; is_read.get(); ++images) {
    std::swap(image, next_image);
    is_read = read_next();
    if (interrupted()) throw RunError("interrupted; nothing was written");
    try {
      emulator.process_image(image, clock.time_us(images), events, wanted_labels);
    } catch (const InputError& error) {
      std::vector<Problem> problems = error.problems();
      for (Problem& problem : problems) problem.place = sequence->name_of(images) + ": " + problem.place;
      throw InputError(std::move(problems));
    }
    luminance.add(image);
    write();
    progress.show(static_cast<double>(images + 1), [&] {
      const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      const std::string total = info.count > 0 ? fmt::format(" of {}", info.count) : "";
      return fmt::format("{:6}{} images, {:6.0f} images/s", images + 1, total,
                         static_cast<double>(images + 1) / std::max(wall_s, 1e-9));
    });
  }
  progress.done();
  clock.check_count(images);
  if (images < 2) {
    throw InputError(options.images.string(), images == 1 ? "one image" : "no images", "at least two");
  }
  emulator.finish(events, wanted_labels);
  write();
  if (label_writer) label_writer->commit();
  writer->commit();

  if (info.count > 0 && images != info.count) {
    fmt::print(stderr, "saccade: {}: read {} images where the file tells of {}\n", options.images.string(),
               images, info.count);
  }
  if (info.linear && luminance.max <= 1.5F && config.dark_current > 0.0 && config.white > 1.5) {
    fmt::print(stderr,
               "saccade: {}: luminance goes up to {:.3g} and white is at {:g}; for images in 0..1 use "
               "--set white=1 --set dark_current=0.04\n",
               options.images.string(), luminance.max, config.white);
  }
  print_summary(options, info, images, clock.time_us(0), clock.time_us(images - 1), luminance,
                emulator.counts());
  return 0;
}

}  // namespace

void add_emulate_command(CommandLine& line) {
  auto options = std::make_shared<EmulateOptions>();
  Command command =
      line.add_command("emulate", "The event camera alone: images or a video in, an event file out");
  command.option("images", options->images, "Folder of images, video, or NumPy array (.npy)").required();
  command.option("--out", options->out, "Event file to write: " + writable_formats()).required();
  command.option("--preset", options->preset, "Event camera, as --set preset=NAME");
  command.option("--config", options->config, "Event camera (YAML), as a scenario's block `emulator`");
  command.option("--set", options->assignments, "key=value of the event camera").one_value_each();
  const Option fps = command.option(
      "--fps", options->images_per_s,
      "Images per second; needed where there are no --timestamps, and a video's own by default");
  command
      .option("--timestamps", options->timestamps,
              "Times, one a line: us, or seconds with a decimal point; an image's name may follow")
      .excludes(fps);
  command.option("--seed", options->seed, "Of everything random in the camera").show_default();
  command.option("--labels", options->labels, "What caused each event, t_us,x,y,p,cause (CSV)");
  command.option("--threads", options->threads, "Processor cores to use; the result does not depend on it")
      .in_range(1, 64)
      .show_default();
  command.flag("--force", options->force, "Replace files that hold something else");
  command.action([options] { return emulate(*options); });
}

}  // namespace saccade
