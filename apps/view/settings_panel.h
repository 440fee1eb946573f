#pragma once

#include <array>
#include <string>
#include <utility>

#include "apps/view/field_editor.h"
#include "apps/view/layout.h"
#include "apps/view/snapshot.h"
#include "apps/view/view_state.h"
#include "config/registry.h"

namespace saccade {

/// The configuration of the selected detector, of controller and gate, and how the eye's image is drawn.
class SettingsPanel {
 public:
  /// `detectors`: those that a user can add.
  explicit SettingsPanel(DetectorRegistry detectors) : detectors_(std::move(detectors)) {}

  void draw(const Area& area, const Snapshot& snapshot, ViewState& state);

 private:
  void draw_configuration(const Snapshot& snapshot, ViewState& state);
  /// The field for the file of a detector outside of this program.
  void draw_own_detector(ViewState& state);

  DetectorRegistry detectors_;
  FieldEditor editor_;
  std::array<char, 512> own_{};    ///< what the user has typed into the field
  std::array<char, 512> tried_{};  ///< what was entered last, and the name of its detector
  std::string tried_name_;
  std::string own_problem_;  ///< why it was rejected
};

}  // namespace saccade
