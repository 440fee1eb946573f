#pragma once

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// The fitted numbers of a model: named arrays of float32, each in the order of its file.
class ModelArrays {
 public:
  /// Throws InputError for a name that another array has.
  void add(const std::string& name, std::vector<float> values);
  /// Copies the array `name`. Throws InputError unless there is one of as many values as `to` has, all finite.
  void copy(std::string_view name, std::span<float> to) const;

 private:
  std::map<std::string, std::vector<float>, std::less<>> arrays_;
};

/// The file of a model that a key names (FieldVisitor::model). An empty path stands for the built-in model.
struct ModelFile {
  std::string path;
  std::shared_ptr<const ModelArrays> arrays;  ///< what the file holds; null until it has been read
};

}  // namespace saccade
