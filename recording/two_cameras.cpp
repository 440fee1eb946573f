#include "recording/two_cameras.h"

#include <algorithm>
#include <array>

#include "core/error.h"

namespace saccade {
namespace {

/// A block of one camera's events.
class Side {
 public:
  Side(std::unique_ptr<EventReader> reader, std::uint8_t camera)
      : reader_(std::move(reader)), camera_(camera) {}

  /// The next event; nullptr at the end. Throws as the reader does.
  [[nodiscard]] const Event* next() {
    if (begin_ == block_.size()) {
      constexpr std::size_t side_events = 4096;
      block_.clear();
      begin_ = 0;
      if (reader_->read(block_, side_events) == 0) return nullptr;
      for (Event& event : block_) event.camera = camera_;
    }
    return &block_[begin_];
  }
  void take() { ++begin_; }
  [[nodiscard]] const EventReader& reader() const { return *reader_; }

 private:
  std::unique_ptr<EventReader> reader_;
  std::uint8_t camera_;
  std::vector<Event> block_;
  std::size_t begin_ = 0;
};

class MergedReader final : public EventReader {
 public:
  MergedReader(std::unique_ptr<EventReader> left, std::unique_ptr<EventReader> right)
      : sides_{Side(std::move(left), 0), Side(std::move(right), 1)} {}

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    try {
      for (; count < max_events; ++count) {
        broken_ = &sides_[0];  // if next() throws
        const Event* left = sides_[0].next();
        broken_ = &sides_[1];
        const Event* right = sides_[1].next();
        if (left == nullptr && right == nullptr) break;
        const bool is_left = right == nullptr || (left != nullptr && left->t_us <= right->t_us);
        events.push_back(is_left ? *left : *right);
        sides_[is_left ? 0 : 1].take();
      }
    } catch (const InputError&) {
      if (count == 0) throw;  // otherwise the next call reads the broken place again and throws
    }
    return count;
  }
  std::optional<ImageSize> image_size() const override {
    const auto left = sides_[0].reader().image_size();
    const auto right = sides_[1].reader().image_size();
    if (!left || !right) return left ? left : right;
    return ImageSize{std::max(left->width, right->width), std::max(left->height, right->height)};
  }
  std::string format() const override { return sides_[0].reader().format() + ", two cameras"; }
  std::string guess() const override { return sides_[0].reader().guess(); }
  std::optional<std::uint64_t> broken_record() const override {
    return broken_ == nullptr ? std::nullopt : broken_->reader().broken_record();
  }
  std::string skipped() const override {
    std::string text = sides_[0].reader().skipped();
    const std::string right = sides_[1].reader().skipped();
    if (!text.empty() && !right.empty()) text += ", ";
    return text + right;
  }

 private:
  std::array<Side, 2> sides_;
  const Side* broken_ = nullptr;
};

class SplittingWriter final : public EventWriter {
 public:
  SplittingWriter(std::unique_ptr<EventWriter> left, std::unique_ptr<EventWriter> right)
      : writers_{std::move(left), std::move(right)} {}

  void write(std::span<const Event> events) override {
    for (std::uint8_t camera = 0; camera < 2; ++camera) {
      part_.clear();
      for (const Event& event : events) {
        if (std::min<std::uint8_t>(event.camera, 1) != camera) continue;
        part_.push_back(event);
        part_.back().camera = event.camera > 1 ? event.camera : 0;  // the writer rejects a third camera
      }
      writers_[camera]->write(part_);
    }
  }
  void sync() override {
    for (const auto& writer : writers_) writer->sync();
  }
  void commit() override {
    writers_[1]->commit();
    writers_[0]->commit();
  }

 private:
  std::array<std::unique_ptr<EventWriter>, 2> writers_;
  std::vector<Event> part_;
};

}  // namespace

std::unique_ptr<EventReader> merge_cameras(std::unique_ptr<EventReader> left,
                                           std::unique_ptr<EventReader> right) {
  return std::make_unique<MergedReader>(std::move(left), std::move(right));
}

std::filesystem::path right_camera_file(const std::filesystem::path& path) {
  return path.parent_path() / (path.stem().string() + "_right" + path.extension().string());
}

std::unique_ptr<EventWriter> split_cameras(std::unique_ptr<EventWriter> left,
                                           std::unique_ptr<EventWriter> right) {
  return std::make_unique<SplittingWriter>(std::move(left), std::move(right));
}

}  // namespace saccade
