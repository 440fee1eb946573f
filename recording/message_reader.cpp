#include "recording/message_reader.h"

#include <algorithm>

#include "recording/codec.h"

namespace saccade {

MessageReader::MessageReader(InputFile file, std::string container, const EventReadOptions& options)
    : BlockReader(std::move(file)), container_(std::move(container)), size_option_(options.image_size) {}

std::optional<ImageSize> MessageReader::image_size() const {
  for (const auto& [id, topic] : topics_) {
    if (topic.decoder && topic.decoder->image_size()) return topic.decoder->image_size();
  }
  return size_option_;
}

std::string MessageReader::format() const {
  std::string text = container_;
  for (const auto& [id, topic] : topics_) {
    if (!topic.decoder) continue;
    const std::string& encoding = topic.decoder->encoding();
    text += " " + printable(topic.type) + (encoding.empty() ? "" : " (" + encoding + ")");
    break;
  }
  return compression_.empty() ? text : text + " " + compression_;
}

std::string MessageReader::skipped() const {
  std::string text;
  for (const auto& [id, topic] : topics_) {
    append_count(text, topic.skipped,
                 "messages of " + printable(topic.name) + " (" + printable(topic.type) + ")");
    if (!topic.decoder) continue;
    const Evt3Decoder& evt3 = topic.decoder->evt3();
    append_count(text, evt3.events_without_time(), "events before the first time stamp");
    append_count(text, evt3.triggers(), "triggers");
    append_count(text, evt3.other_words(), "words that are no events");
  }
  return text;
}

void MessageReader::read_ahead() {
  try {
    while (events_.empty() && !failure_ && next()) {
    }
  } catch (const InputError& error) {
    failure_ = error;
  }
}

void MessageReader::add_topic(std::uint32_t id, const std::string& name, const std::string& type,
                              Serialisation serialisation) {
  if (topics_.contains(id)) return;
  Topic topic{name, type, std::nullopt, 0, 0};
  if (const auto message = event_message_type(type)) {
    const auto has = [&](std::uint8_t camera) {
      return std::ranges::any_of(topics_, [camera](const auto& other) {
        return other.second.decoder && other.second.camera == camera;
      });
    };
    const bool is_right = name.find("right") != std::string::npos;
    const bool is_left = name.find("left") != std::string::npos;
    topic.camera = is_right || (!is_left && has(0)) ? 1 : 0;
    if (!has(topic.camera)) topic.decoder.emplace(*message, serialisation);
  }
  topics_.emplace(id, std::move(topic));
}

bool MessageReader::wants(std::uint32_t id) {
  const auto topic = topics_.find(id);
  if (topic == topics_.end())
    file_.fail("a message of the unknown topic " + std::to_string(id), "a topic that is announced before");
  if (!topic->second.decoder) ++topic->second.skipped;
  return topic->second.decoder.has_value();
}

void MessageReader::take(std::uint32_t id, std::string_view message, std::uint64_t host_ns) {
  Topic& topic = topics_.at(id);
  events_.clear();
  next_ = 0;
  const std::optional<BrokenMessage> broken = topic.decoder->decode(message, events_);
  for (Event& event : events_) event.camera = topic.camera;
  if (!events_.empty() && host_ns != 0) {
    const std::int64_t ahead_us = static_cast<std::int64_t>(host_ns / 1000) - events_.back().t_us;
    host_ahead_us_ = std::min(ahead_us, host_ahead_us_.value_or(ahead_us));
  }
  if (!broken) return;
  try {
    file_.fail(broken->found, broken->expected);
  } catch (const InputError& error) {
    failure_ = error;
  }
}

std::unique_ptr<Decompressor> MessageReader::decompressor(const std::string& word) {
  if (word.empty() || word == "none") return make_copier();
  compression_ = word == "lz4" ? "LZ4" : word == "zstd" ? "ZSTD" : word == "bz2" ? "BZ2" : "";
  if (word == "lz4") return make_lz4_decompressor();
  if (word == "zstd") return make_zstd_decompressor();
  if (word == "bz2") return make_bzip2_decompressor();
  file_.fail("the compression " + printable(word), "none, lz4, bz2 or zstd");
}

bool MessageReader::decode(std::span<Event> block, std::size_t& count) {
  while (next_ == events_.size()) {
    if (failure_) throw InputError(*failure_);
    events_.clear();
    next_ = 0;
    if (!next()) return false;
  }
  count = std::min(block.size(), events_.size() - next_);
  std::copy_n(events_.begin() + static_cast<std::ptrdiff_t>(next_), count, block.begin());
  next_ += count;
  return true;
}

}  // namespace saccade
