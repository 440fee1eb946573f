#include "evaluation/replay/foxglove_schemas.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;

Json of_type(const char* type) {
  Json schema = Json::object();
  schema["type"] = type;
  return schema;
}
Json number() { return of_type("number"); }
Json text() { return of_type("string"); }
Json truth_value() { return of_type("boolean"); }
Json whole() {
  Json schema = of_type("integer");
  schema["minimum"] = 0;
  return schema;
}
Json bytes() {
  Json schema = text();
  schema["contentEncoding"] = "base64";
  return schema;
}
Json list(Json items, int count = -1) {
  Json schema = of_type("array");
  schema["items"] = std::move(items);
  if (count >= 0) schema["minItems"] = schema["maxItems"] = count;
  return schema;
}

using Members = std::vector<std::pair<const char*, Json>>;

/// All members are required.
Json object(const std::string& title, const Members& members) {
  Json schema = Json::object();
  schema["title"] = title;
  schema["type"] = "object";
  schema["properties"] = Json::object();
  schema["required"] = Json::array();
  for (const auto& [name, member] : members) {
    schema["properties"][name] = member;
    schema["required"].push_back(name);
  }
  return schema;
}

/// sec and nsec of a time or a duration.
Json moment(const char* title) {
  constexpr int largest_ns = 999'999'999;
  Json nsec = whole();
  nsec["maximum"] = largest_ns;
  Json schema = object(title, {{"sec", whole()}, {"nsec", nsec}});
  schema.erase("required");
  return schema;
}
Json time() { return moment("time"); }
Json point_2() { return object("foxglove.Point2", {{"x", number()}, {"y", number()}}); }
Json point_3() { return object("foxglove.Point3", {{"x", number()}, {"y", number()}, {"z", number()}}); }
Json vector_3() { return object("foxglove.Vector3", {{"x", number()}, {"y", number()}, {"z", number()}}); }
Json quaternion() {
  return object("foxglove.Quaternion", {{"x", number()}, {"y", number()}, {"z", number()}, {"w", number()}});
}
Json colour() {
  return object("foxglove.Color", {{"r", number()}, {"g", number()}, {"b", number()}, {"a", number()}});
}
Json pose() { return object("foxglove.Pose", {{"position", vector_3()}, {"orientation", quaternion()}}); }

Json compressed_image() {
  return object("foxglove.CompressedImage",
                {{"timestamp", time()}, {"frame_id", text()}, {"data", bytes()}, {"format", text()}});
}

Json raw_image() {
  return object("foxglove.RawImage", {{"timestamp", time()},
                                      {"frame_id", text()},
                                      {"width", whole()},
                                      {"height", whole()},
                                      {"encoding", text()},
                                      {"step", whole()},
                                      {"data", bytes()}});
}

Json image_annotations() {
  const Json circle = object("foxglove.CircleAnnotation", {{"timestamp", time()},
                                                           {"position", point_2()},
                                                           {"diameter", number()},
                                                           {"thickness", number()},
                                                           {"fill_color", colour()},
                                                           {"outline_color", colour()}});
  const Json points = object("foxglove.PointsAnnotation", {{"timestamp", time()},
                                                           {"type", whole()},
                                                           {"points", list(point_2())},
                                                           {"outline_color", colour()},
                                                           {"outline_colors", list(colour())},
                                                           {"fill_color", colour()},
                                                           {"thickness", number()}});
  const Json label = object("foxglove.TextAnnotation", {{"timestamp", time()},
                                                        {"position", point_2()},
                                                        {"text", text()},
                                                        {"font_size", number()},
                                                        {"text_color", colour()},
                                                        {"background_color", colour()}});
  return object("foxglove.ImageAnnotations",
                {{"circles", list(circle)}, {"points", list(points)}, {"texts", list(label)}});
}

Json camera_calibration() {
  constexpr int matrix = 9;
  constexpr int projection = 12;
  return object("foxglove.CameraCalibration", {{"timestamp", time()},
                                               {"frame_id", text()},
                                               {"width", whole()},
                                               {"height", whole()},
                                               {"distortion_model", text()},
                                               {"D", list(number())},
                                               {"K", list(number(), matrix)},
                                               {"R", list(number(), matrix)},
                                               {"P", list(number(), projection)}});
}

Json frame_transforms() {
  const Json transform = object("foxglove.FrameTransform", {{"timestamp", time()},
                                                            {"parent_frame_id", text()},
                                                            {"child_frame_id", text()},
                                                            {"translation", vector_3()},
                                                            {"rotation", quaternion()}});
  return object("foxglove.FrameTransforms", {{"transforms", list(transform)}});
}

Json scene_update() {
  const Json pair = object("foxglove.KeyValuePair", {{"key", text()}, {"value", text()}});
  const Json arrow = object("foxglove.ArrowPrimitive", {{"pose", pose()},
                                                        {"shaft_length", number()},
                                                        {"shaft_diameter", number()},
                                                        {"head_length", number()},
                                                        {"head_diameter", number()},
                                                        {"color", colour()}});
  const Json cube =
      object("foxglove.CubePrimitive", {{"pose", pose()}, {"size", vector_3()}, {"color", colour()}});
  const Json sphere =
      object("foxglove.SpherePrimitive", {{"pose", pose()}, {"size", vector_3()}, {"color", colour()}});
  const Json cylinder = object("foxglove.CylinderPrimitive", {{"pose", pose()},
                                                              {"size", vector_3()},
                                                              {"bottom_scale", number()},
                                                              {"top_scale", number()},
                                                              {"color", colour()}});
  const Json line = object("foxglove.LinePrimitive", {{"type", whole()},
                                                      {"pose", pose()},
                                                      {"thickness", number()},
                                                      {"scale_invariant", truth_value()},
                                                      {"points", list(point_3())},
                                                      {"color", colour()},
                                                      {"colors", list(colour())},
                                                      {"indices", list(whole())}});
  const Json triangles = object("foxglove.TriangleListPrimitive", {{"pose", pose()},
                                                                   {"points", list(point_3())},
                                                                   {"color", colour()},
                                                                   {"colors", list(colour())},
                                                                   {"indices", list(whole())}});
  const Json label = object("foxglove.TextPrimitive", {{"pose", pose()},
                                                       {"billboard", truth_value()},
                                                       {"font_size", number()},
                                                       {"scale_invariant", truth_value()},
                                                       {"color", colour()},
                                                       {"text", text()}});
  const Json model = object("foxglove.ModelPrimitive", {{"pose", pose()},
                                                        {"scale", vector_3()},
                                                        {"color", colour()},
                                                        {"override_color", truth_value()},
                                                        {"url", text()},
                                                        {"media_type", text()},
                                                        {"data", bytes()}});
  const Json entity = object("foxglove.SceneEntity", {{"timestamp", time()},
                                                      {"frame_id", text()},
                                                      {"id", text()},
                                                      {"lifetime", moment("duration")},
                                                      {"frame_locked", truth_value()},
                                                      {"metadata", list(pair)},
                                                      {"arrows", list(arrow)},
                                                      {"cubes", list(cube)},
                                                      {"spheres", list(sphere)},
                                                      {"cylinders", list(cylinder)},
                                                      {"lines", list(line)},
                                                      {"triangles", list(triangles)},
                                                      {"texts", list(label)},
                                                      {"models", list(model)}});
  const Json deletion =
      object("foxglove.SceneEntityDeletion", {{"timestamp", time()}, {"type", whole()}, {"id", text()}});
  return object("foxglove.SceneUpdate", {{"deletions", list(deletion)}, {"entities", list(entity)}});
}

}  // namespace

std::string foxglove_schema(std::string_view name) {
  const auto made = [&]() -> Json {
    if (name == "foxglove.CompressedImage") return compressed_image();
    if (name == "foxglove.RawImage") return raw_image();
    if (name == "foxglove.ImageAnnotations") return image_annotations();
    if (name == "foxglove.CameraCalibration") return camera_calibration();
    if (name == "foxglove.FrameTransforms") return frame_transforms();
    SACCADE_CHECK(name == "foxglove.SceneUpdate");
    return scene_update();
  };
  return made().dump();
}

std::string plain_schema(std::string_view name, const std::vector<PlainMember>& members) {
  Json schema = object(std::string(name), {{"timestamp", time()}});
  for (const PlainMember& member : members) {
    Json& property = schema["properties"][member.name];
    switch (member.kind) {
      case PlainMember::Kind::number:
        property = number();
        break;
      case PlainMember::Kind::vector:
        property = vector_3();
        break;
      case PlainMember::Kind::truth_value:
        property = truth_value();
        break;
    }
  }
  return schema.dump();
}

}  // namespace saccade
