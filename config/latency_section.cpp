#include "config/latency_section.h"

#include <algorithm>

#include "config/yaml_reader.h"
#include "config/yaml_writer.h"
#include "evaluation/frame_camera/frame_detector.h"

namespace saccade {
namespace {

bool has(const LatencyConfig& latency, std::string_view name) {
  return std::ranges::any_of(latency.detectors, [&](const auto& named) { return named.first == name; });
}

/// One entry for each detector, in their order.
void fit_to(LatencyConfig& latency, const NamedDetectors& detectors, bool frame_camera) {
  std::vector<std::pair<std::string, WorkTime>> fitting;
  for (const auto& [name, config] : detectors)
    fitting.emplace_back(name, latency.work_of(has(latency, name) ? name : std::string(config.preset())));
  if (frame_camera) {
    const std::string name(frame_detector_name);
    fitting.emplace_back(name, latency.work_of(name));
  }
  latency.detectors = std::move(fitting);
}

/// The file of `saccade fit-latency`.
void describe_file(FieldVisitor& v, LatencyConfig& latency) {
  v.section(
      "latency",
      [&](FieldVisitor& w) {
        w.real("controller_us", latency.controller_us, {0.0, 1e6}, "a step of the controller");
        w.named_sections("detectors", latency.detectors, "processing times by detector", "a detector");
      },
      "processing times of a machine");
}

}  // namespace

void describe_latency(FieldVisitor& v, LatencyConfig& latency, const NamedDetectors& detectors,
                      bool frame_camera) {
  v.choice(
      "kind", latency.kind,
      "none: nothing takes time; model: the times below; measured: detectors and controller take what the "
      "clock measures, and two runs differ");
  v.when(latency.kind == LatencyKind::model, "kind: model", [&] {
    const auto file = v.file("file", "file of `saccade fit-latency` with the values of the keys below");
    if (file) {
      const LatencyConfig fitted = read_latency(*file);
      latency.controller_us = fitted.controller_us;
      latency.detectors = fitted.detectors;
    }
  });
  v.when(latency.kind != LatencyKind::none, "kind: model or measured", [&] { describe_times(v, latency); });
  v.when(latency.kind == LatencyKind::model, "kind: model", [&] {
    fit_to(latency, detectors, frame_camera);
    v.section(
        "detectors",
        [&](FieldVisitor& block) {
          for (auto& [name, work] : latency.detectors) block.section(name, work, "a detector");
        },
        "processing times by detector");
  });
}

LatencyConfig read_latency(const std::filesystem::path& path) {
  const YamlTree tree = read_yaml_file(path);
  YamlReader reader(tree, {"latency", "latency.detectors"});
  LatencyConfig latency;
  describe_file(reader, latency);
  reader.finish();
  return latency;
}

std::string latency_yaml(LatencyConfig latency) {
  YamlWriter writer;
  describe_file(writer, latency);
  return writer.yaml();
}

}  // namespace saccade
