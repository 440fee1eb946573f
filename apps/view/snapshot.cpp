#include "apps/view/snapshot.h"

#include "core/error.h"

namespace saccade {

void Snapshot::use_model(const std::shared_ptr<const mjModel>& new_model) {
  if (model == new_model && scene) return;
  scene.reset(mj_makeData(new_model.get()));
  if (!scene) throw RunError("MuJoCo has no memory for a snapshot of the world");
  model = new_model;
}

}  // namespace saccade
