#include "recording/message_reader.h"

#include <algorithm>

#include "recording/codec.h"

namespace saccade {

MessageReader::MessageReader(InputFile file, std::string container, const EventReadOptions& options)
    : BlockReader(std::move(file)),
      container_(std::move(container)),
      size_option_(options.image_size),
      others_(options.others) {}

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
    append_counts(text, topic.decoder->packets().counts());
  }
  return text;
}

bool MessageReader::needs_message() const {
  const auto& [left, right] = queues_;
  if (left.size() == 0 && right.size() == 0) return true;
  if (!left.has_topic || !right.has_topic) return false;
  return (left.size() == 0 && right.size() < most_ahead) || (right.size() == 0 && left.size() < most_ahead);
}

void MessageReader::read_ahead() {
  try {
    while (!over_ && !failure_ && needs_message()) over_ = !next();
  } catch (const InputError& error) {
    failure_ = error;
  }
}

void MessageReader::add_topic(std::uint32_t id, const std::string& name, const std::string& type,
                              Serialisation serialisation) {
  if (topics_.contains(id)) return;
  Topic topic{name, type, std::nullopt, wanted_sensor_message(others_, type), serialisation, 0, 0};
  if (const auto message = event_message_type(type)) {
    const auto has = [&](std::uint8_t camera) {
      return std::ranges::any_of(topics_, [camera](const auto& other) {
        return other.second.decoder && other.second.camera == camera;
      });
    };
    const bool is_right = name.find("right") != std::string::npos;
    const bool is_left = name.find("left") != std::string::npos;
    topic.camera = is_right || (!is_left && has(0)) ? 1 : 0;
    if (!has(topic.camera)) topic.decoder.emplace(*message, serialisation, others_, name);
    queues_[topic.camera].has_topic = true;
  }
  topics_.emplace(id, std::move(topic));
}

bool MessageReader::wants(std::uint32_t id) {
  const auto topic = topics_.find(id);
  if (topic == topics_.end())
    file_.fail("a message of the unknown topic " + std::to_string(id), "a topic that is announced before");
  const bool is_wanted = topic->second.decoder || topic->second.sensor;
  if (!is_wanted) ++topic->second.skipped;
  return is_wanted;
}

void MessageReader::take(std::uint32_t id, std::string_view message, std::uint64_t host_ns) {
  Topic& topic = topics_.at(id);
  if (!topic.decoder) {
    keep(read_sensor_message(*topic.sensor, topic.serialisation, message, topic.name, *others_));
    return;
  }
  Queue& queue = queues_[topic.camera];
  if (queue.next > queue.size()) {
    queue.events.erase(queue.events.begin(), queue.events.begin() + static_cast<std::ptrdiff_t>(queue.next));
    queue.next = 0;
  }
  const std::size_t before = queue.events.size();
  const std::optional<BrokenMessage> broken = topic.decoder->decode(message, queue.events);
  for (Event& event : std::span(queue.events).subspan(before)) event.camera = topic.camera;
  if (queue.events.size() > before && host_ns != 0) {
    const std::int64_t ahead_us = static_cast<std::int64_t>(host_ns / 1000) - queue.events.back().t_us;
    host_ahead_us_ = std::min(ahead_us, host_ahead_us_.value_or(ahead_us));
  }
  keep(broken);
}

void MessageReader::keep(const std::optional<BrokenMessage>& broken) {
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
  auto& [left, right] = queues_;
  while (count < block.size()) {
    read_ahead();
    if (left.size() == 0 && right.size() == 0) {
      if (count == 0 && failure_) throw InputError(*failure_);
      return count > 0;
    }
    if (left.size() == 0 || right.size() == 0) {
      // Of one camera alone, a piece; while the other one is not waited for, event by event.
      Queue& queue = left.size() > 0 ? left : right;
      const bool is_alone = !left.has_topic || !right.has_topic || over_ || failure_;
      const std::size_t piece = is_alone ? std::min(block.size() - count, queue.size()) : 1;
      std::copy_n(queue.events.begin() + static_cast<std::ptrdiff_t>(queue.next), piece,
                  block.begin() + static_cast<std::ptrdiff_t>(count));
      queue.next += piece;
      count += piece;
      continue;
    }
    while (count < block.size() && left.size() > 0 && right.size() > 0) {
      Queue& queue = left.events[left.next].t_us <= right.events[right.next].t_us ? left : right;
      block[count++] = queue.events[queue.next++];
    }
  }
  return true;
}

}  // namespace saccade
