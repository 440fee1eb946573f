#pragma once

#include <memory>
#include <type_traits>
#include <utility>

#include "core/config.h"

namespace saccade {

/// A config struct of any type, held by value: a copy has a config of its own. The struct has a
/// `describe(FieldVisitor&, Config&)` beside it.
class TypeErasedConfig {
 public:
  template <class Config>
  requires(!std::is_same_v<std::remove_cvref_t<Config>, TypeErasedConfig>) explicit TypeErasedConfig(
      Config config)
      : held_(std::make_unique<Held<Config>>(std::move(config))) {}

  TypeErasedConfig(const TypeErasedConfig& other) : held_(other.held_->clone()) {}
  TypeErasedConfig(TypeErasedConfig&&) noexcept = default;
  TypeErasedConfig& operator=(const TypeErasedConfig& other) {
    held_ = other.held_->clone();
    return *this;
  }
  TypeErasedConfig& operator=(TypeErasedConfig&&) noexcept = default;
  ~TypeErasedConfig() = default;

  /// The config if it is of this type, else nullptr.
  template <class Config>
  [[nodiscard]] Config* get_if() {
    auto* const held = dynamic_cast<Held<Config>*>(held_.get());
    return held != nullptr ? &held->config : nullptr;
  }
  template <class Config>
  [[nodiscard]] const Config* get_if() const {
    return const_cast<TypeErasedConfig*>(this)->get_if<Config>();
  }
  /// The config, which is of this type.
  template <class Config>
  [[nodiscard]] Config& get() {
    Config* const config = get_if<Config>();
    SACCADE_CHECK(config != nullptr);
    return *config;
  }
  template <class Config>
  [[nodiscard]] const Config& get() const {
    return const_cast<TypeErasedConfig*>(this)->get<Config>();
  }

  friend void describe(FieldVisitor& v, TypeErasedConfig& config) { config.held_->visit(v); }

 private:
  struct Base {
    virtual ~Base() = default;
    [[nodiscard]] virtual std::unique_ptr<Base> clone() const = 0;
    virtual void visit(FieldVisitor& v) = 0;
  };
  template <class Config>
  struct Held final : Base {
    explicit Held(Config c) : config(std::move(c)) {}
    [[nodiscard]] std::unique_ptr<Base> clone() const override { return std::make_unique<Held>(config); }
    void visit(FieldVisitor& v) override { describe(v, config); }

    Config config;
  };

  std::unique_ptr<Base> held_;
};

/// `make(const Config&, args...)` as a function of an TypeErasedConfig that holds a Config.
template <class Config, class Make>
[[nodiscard]] auto for_erased_config(Make make) {
  return [make = std::move(make)](const TypeErasedConfig& config, const auto&... args) {
    return make(config.get<Config>(), args...);
  };
}

/// The config of what has no keys.
struct NoKeys {};
inline void describe(FieldVisitor&, NoKeys&) {}

}  // namespace saccade
