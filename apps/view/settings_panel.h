#pragma once

#include "apps/view/field_editor.h"
#include "apps/view/layout.h"
#include "apps/view/snapshot.h"
#include "apps/view/view_state.h"

namespace saccade {

/// The configuration of the selected detector, of controller and gate, and how the eye's image is drawn.
class SettingsPanel {
 public:
  void draw(const Area& area, const Snapshot& snapshot, ViewState& state);

 private:
  void draw_configuration(ViewState& state);

  FieldEditor editor_;
};

}  // namespace saccade
