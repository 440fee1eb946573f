#include "recording/yarp_log_codec.h"

#include <algorithm>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/input_file.h"
#include "recording/yarp_codec.h"
#include "recording/yarp_log_info.h"
#include "recording/yarp_log_packets.h"

namespace saccade {
namespace {

/// How much of a log is read to guess its codec.
constexpr std::size_t sample_words = 1 << 12;
constexpr std::size_t sample_packets = 256;

class YarpLogReader final : public EventReader {
 public:
  YarpLogReader(std::unique_ptr<YarpPacketSource> source, std::string_view kind,
                const EventReadOptions& options)
      : source_(std::move(source)), kind_(kind) {
    const std::filesystem::path path = source_->name();
    const std::string named = yarp_info(path, yarp_codec_key);
    if (options.yarp_codec != "auto") {
      codec_ = yarp_codec(options.yarp_codec, "codec");
    } else if (!named.empty()) {
      codec_ = yarp_codec(named, yarp_info_file(path).string());
    } else {
      take_sample();
      codec_ = guess_yarp_codec(sample_);
      guessed_ = true;
    }
    ns_per_tick_ = tick_ns(codec_.address);
    time_ = StampUnwrapper(ns_per_tick_,
                           static_cast<int>(yarp_info_number(path, yarp_bits_key, 31, codec_.stamp_bits)));
    origin_us_ = yarp_info_number(path, yarp_origin_key, std::int64_t{1} << 60, 0);
    image_size_ = options.image_size;
    if (!image_size_) image_size_ = yarp_info_size(path);
    if (!image_size_) image_size_ = codec_.image_size;
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    const std::size_t before = events.size();
    try {
      while (events.size() - before < max_events) {
        if (next_event_ == ready_.size() && !decode_packet()) break;
        const std::size_t count =
            std::min(ready_.size() - next_event_, max_events - (events.size() - before));
        const auto first = ready_.begin() + static_cast<std::ptrdiff_t>(next_event_);
        events.insert(events.end(), first, first + static_cast<std::ptrdiff_t>(count));
        next_event_ += count;
      }
    } catch (const InputError&) {
      if (events.size() == before) throw;  // otherwise the next call reads the broken packet again and throws
    }
    return events.size() - before;
  }

  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override {
    return kind_ + ", codec " + std::string(codec_.name) + (guessed_ ? " (guessed)" : "");
  }
  std::string guess() const override {
    return guessed_ ? "the codec " + std::string(codec_.name) + ", from the first packets; --codec sets it"
                    : "";
  }
  std::string skipped() const override {
    std::string text;
    if (skin_events_ > 0) text = std::to_string(skin_events_) + " skin events";
    if (source_->others() > 0) {
      text += (text.empty() ? "" : ", ") + std::to_string(source_->others()) + " lists not AE";
    }
    return text;
  }
  std::optional<std::int64_t> host_ahead_us() const override { return host_ahead_us_; }
  std::optional<std::uint64_t> broken_record() const override { return source_->packet_begin(); }

 private:
  /// Reads the first packets, to guess from. A broken place is reported when the events before it have been returned.
  void take_sample() {
    std::size_t words = 0;
    try {
      YarpPacket packet;
      while (words < sample_words && sample_.size() < sample_packets && source_->next(packet)) {
        words += packet.words.size();
        sample_.push_back(packet);
      }
    } catch (const InputError&) {
    }
  }

  /// Makes the events of one more packet ready; false at the end.
  bool decode_packet() {
    ready_.clear();
    next_event_ = 0;
    if (next_sample_ < sample_.size()) {
      packet_ = std::move(sample_[next_sample_++]);
    } else if (!source_->next(packet_)) {
      return false;
    }
    const std::vector<std::uint32_t>& words = packet_.words;
    if (packet_.of_bytes && !codec_.stamped) {
      for (std::size_t i = 0; i < words.size(); ++i) add(spread_time(i), words[i]);
      host_ahead_us_ = 0;
      return true;
    }
    if (words.size() % 2 != 0) {
      throw InputError(
          source_->name(), "a packet of " + std::to_string(4 * words.size()) + " bytes",
          "stamps and addresses, 8 bytes each, as the codec " + std::string(codec_.name) + " has");
    }
    std::int64_t t_us = 0;
    for (std::size_t i = 0; i < words.size(); i += 2) {
      const std::int64_t ticks = time_.extend(words[i], packet_.host_s);
      t_us = origin_us_ + us_from_ticks(ticks, ns_per_tick_);
      add(t_us, words[i + 1]);
    }
    if (packet_.host_s > 0.0 && !words.empty()) {
      const std::int64_t ahead_us = packet_.host_us - t_us;
      host_ahead_us_ = std::min(host_ahead_us_.value_or(ahead_us), ahead_us);
    }
    return true;
  }

  /// Of a word without a stamp.
  [[nodiscard]] std::int64_t spread_time(std::size_t i) const {
    const auto count = static_cast<std::int64_t>(packet_.words.size());
    const auto left = count - 1 - static_cast<std::int64_t>(i);
    return packet_.host_us - packet_.duration_us * left / count;
  }

  void add(std::int64_t t_us, std::uint32_t word) {
    if (const std::optional<Event> event = codec_.decode(t_us, word)) {
      ready_.push_back(*event);
    } else {
      ++skin_events_;
    }
  }

  std::unique_ptr<YarpPacketSource> source_;
  std::string kind_;
  YarpCodec codec_;
  bool guessed_ = false;
  std::optional<ImageSize> image_size_;
  std::int64_t ns_per_tick_ = 0;
  StampUnwrapper time_{1, 0};
  std::int64_t origin_us_ = 0;
  std::vector<YarpPacket> sample_;
  std::size_t next_sample_ = 0;
  YarpPacket packet_;
  std::vector<Event> ready_;
  std::size_t next_event_ = 0;
  std::int64_t skin_events_ = 0;
  std::optional<std::int64_t> host_ahead_us_;
};

/// A binary dump has no mark; its name or its info file identifies it.
bool is_yarp_binary(const std::filesystem::path& path) {
  return path.filename() == "binaryevents.log" ||
         (path.extension() == ".log" && yarp_info(path, yarp_type_key) == "Binary");
}

}  // namespace

RecordingFormat yarp_log_format() {
  RecordingFormat format;
  format.name = "event-driven log";
  format.extensions = {".log"};
  format.file_in_folder = "data.log";
  format.sniff = [](const FileStart& start) {
    return looks_like_yarp_log(start.bytes) ? Match::likely : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<YarpLogReader>(yarp_text_packets(std::move(file)), "event-driven log", options);
  };
  format.create = create_yarp_log;
  format.companions = [](const std::filesystem::path& path) {
    return std::vector<std::filesystem::path>{yarp_info_file(path)};
  };
  format.cameras = 2;
  format.reads =
      "version 1: lists AE of every codec, [see below](#event-driven-logs); version 2: packets AE, with or "
      "without a "
      "time stamp in each event";
  format.writes = "version 2 with time stamps, info file beside it";
  format.time =
      "ticks of 80 or 128 ns, to the nearest us; counters of 24 to 31 bits, continued with the host's time; "
      "without "
      "stamps spread over the packet's duration; written: 31 bits of 80 ns and `Origin` in the info file";
  format.axes = "0 is ON; two cameras";
  format.limits = "2048 x 1024, times from 0 on";
  return format;
}

RecordingFormat yarp_binary_format() {
  RecordingFormat format;
  format.name = "event-driven binary dump";
  format.extensions = {".log"};
  format.file_in_folder = "binaryevents.log";
  format.sniff = [](const FileStart& start) {
    return is_yarp_binary(start.path) ? Match::certain : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<YarpLogReader>(yarp_binary_packets(std::move(file)), "event-driven binary log",
                                           options);
  };
  format.reads = "`binaryevents.log`, or any log with `Type: Binary` in its info file";
  format.time =
      "as event-driven log, without the host's time: no silence longer than half the counter's range";
  format.axes = "0 is ON; two cameras";
  return format;
}

}  // namespace saccade
