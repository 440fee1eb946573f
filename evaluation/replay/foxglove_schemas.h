#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// JSON Schema (draft 7) of one of Foxglove's schemas that foxglove_file.h writes, by its name: foxglove.CompressedImage,
/// .RawImage, .ImageAnnotations, .CameraCalibration, .FrameTransforms, .SceneUpdate.
[[nodiscard]] std::string foxglove_schema(std::string_view name);

/// A message with a `timestamp` and members that may be absent, of which each is a number, a vector x, y, z or a truth value.
struct PlainMember {
  enum class Kind { number, vector, truth_value };
  std::string name;
  Kind kind = Kind::number;
};
[[nodiscard]] std::string plain_schema(std::string_view name, const std::vector<PlainMember>& members);

}  // namespace saccade
