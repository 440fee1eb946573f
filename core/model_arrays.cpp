#include "core/model_arrays.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace saccade {

void ModelArrays::add(const std::string& name, std::vector<float> values) {
  if (arrays_.contains(name)) throw InputError("array " + name, "two of them", "each name once");
  arrays_[name] = std::move(values);
}

void ModelArrays::copy(std::string_view name, std::span<float> to) const {
  const std::string place = "array " + std::string(name);
  const auto found = arrays_.find(name);
  const std::string expected = std::to_string(to.size()) + " finite numbers";
  if (found == arrays_.end()) throw InputError(place, "no such array", expected);
  const std::vector<float>& values = found->second;
  if (values.size() != to.size())
    throw InputError(place, std::to_string(values.size()) + " numbers", expected);
  if (!std::ranges::all_of(values, [](float value) { return std::isfinite(value); }))
    throw InputError(place, "a number that is not finite", expected);
  std::ranges::copy(values, to.begin());
}

}  // namespace saccade
