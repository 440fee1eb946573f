#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace saccade {

/// The newest value from one thread for any number of others. No side waits for another, whatever the other does: a writer
/// that is halted within a write leaves the value before. Writers need a lock among themselves.
template <class T>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit LatestValue(const T& first = {}) { write(first); }

  void write(const T& value) {
    const std::uint64_t count = written_.load(std::memory_order_relaxed) + 1;
    Slot& slot = slots_[count % slots_.size()];
    std::array<std::uint64_t, words> word{};
    std::memcpy(word.data(), &value, sizeof(T));
    slot.count.store(0, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < words; ++i) slot.word[i].store(word[i], std::memory_order_relaxed);
    slot.count.store(count, std::memory_order_release);
    written_.store(count, std::memory_order_release);
  }

  [[nodiscard]] T read() const {
    std::array<std::uint64_t, words> word;
    for (;;) {  // once; again only if four values were written meanwhile
      const std::uint64_t count = written_.load(std::memory_order_acquire);
      const Slot& slot = slots_[count % slots_.size()];
      if (slot.count.load(std::memory_order_acquire) != count) continue;
      for (std::size_t i = 0; i < words; ++i) word[i] = slot.word[i].load(std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_acquire);
      if (slot.count.load(std::memory_order_relaxed) == count) break;
    }
    T value;
    std::memcpy(static_cast<void*>(&value), word.data(), sizeof(T));
    return value;
  }

  /// Number of values written so far; each one is another.
  [[nodiscard]] std::uint64_t count() const { return written_.load(std::memory_order_acquire); }

 private:
  static constexpr std::size_t words = (sizeof(T) + 7) / 8;
  struct Slot {
    std::atomic<std::uint64_t> count = 0;  ///< of the value in it; 0 while it is written
    std::array<std::atomic<std::uint64_t>, words> word{};
  };

  std::array<Slot, 4> slots_;
  std::atomic<std::uint64_t> written_ = 0;
};

}  // namespace saccade
