#include "sim/model_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "core/config.h"
#include "core/error.h"
#include "sim/triangle_mesh.h"

namespace saccade {
namespace {

using Eigen::Vector3d;
using RowMajor = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;

constexpr int largest_group = 2;
constexpr double largest_object_m = 5.0;
constexpr double largest_lab_m = 100.0;

std::string in_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

template <class Number>
std::string list(const Number* values, int count) {
  std::string text;
  std::array<char, 32> number{};
  for (int i = 0; i < count; ++i) {
    std::snprintf(number.data(), number.size(), "%.7g", static_cast<double>(values[i]));
    text += (i == 0 ? "" : " ") + std::string(number.data());
  }
  return text;
}

std::string attribute(const char* name, const std::string& value) {
  return " " + std::string(name) + "=\"" + value + "\"";
}

std::string name_in(const mjModel& m, mjtObj type, int id) {
  const char* name = mj_id2name(&m, type, id);
  return name != nullptr && *name != '\0' ? "\"" + std::string(name) + "\"" : "number " + std::to_string(id);
}

/// A compiled model as the parts of another.
class Converter {
 public:
  Converter(const mjModel& model, const std::string& path, const std::string& prefix, ModelUse use)
      : m_(model), path_(path), prefix_(prefix), use_(use), data_(mj_makeData(&model)) {
    if (!data_) throw RunError("MuJoCo has no memory for " + path);
    mj_kinematics(&m_, data_.get());
    mj_comPos(&m_, data_.get());
    mj_camlight(&m_, data_.get());
  }

  ModelParts parts() {
    check_joints();
    for (int geom = 0; geom < m_.ngeom; ++geom) {
      if (m_.geom_group[geom] >= 0 && m_.geom_group[geom] <= largest_group) add_geom(geom);
    }
    if (parts_.geoms.empty()) refuse("no geoms of groups 0 to 2", "a model with geoms");
    const double limit_m = use_ == ModelUse::object ? largest_object_m : largest_lab_m;
    if (farthest_m_ > limit_m) {
      refuse("a geom " + text_of(farthest_m_) + " m from the origin",
             "a model in metres, within " + text_of(limit_m) + " m");
    }
    if (use_ == ModelUse::lab) {
      for (int light = 0; light < m_.nlight; ++light) add_light(light);
    }
    return std::move(parts_);
  }

 private:
  [[noreturn]] void refuse(const std::string& found, const std::string& expectation) const {
    throw InputError(path_, found, expectation);
  }

  void check_joints() const {
    constexpr std::array<const char*, 4> kinds = {"free", "ball", "slide", "hinge"};
    for (int joint = 0; joint < m_.njnt; ++joint) {
      const bool dropped = use_ == ModelUse::object && m_.njnt == 1 && m_.jnt_type[joint] == mjJNT_FREE;
      if (dropped) continue;
      refuse("the " + std::string(kinds.at(static_cast<std::size_t>(m_.jnt_type[joint]))) + " joint " +
                 name_in(m_, mjOBJ_JOINT, joint),
             use_ == ModelUse::object ? "a rigid object without joints, or with one free joint"
                                      : "a lab without joints");
    }
  }

  void add_geom(int geom) {
    const int type = m_.geom_type[geom];
    if (type == mjGEOM_HFIELD)
      refuse("the height field " + name_in(m_, mjOBJ_GEOM, geom), "other geoms, such as a mesh");
    if (type == mjGEOM_PLANE && use_ == ModelUse::object) {
      refuse("the plane " + name_in(m_, mjOBJ_GEOM, geom), "geoms of finite size");
    }
    const Vector3d at_m = Eigen::Map<const Vector3d>(data_->geom_xpos + 3 * geom);
    if (type != mjGEOM_PLANE) farthest_m_ = std::max(farthest_m_, at_m.norm() + m_.geom_rbound[geom]);
    std::string element = "<geom type=\"" + std::string(mju_type_name(type)) + "\"";
    if (type == mjGEOM_MESH) {
      element += attribute("mesh", mesh_of(geom));
    } else {
      const Eigen::Quaterniond turn(Eigen::Matrix3d(Eigen::Map<const RowMajor>(data_->geom_xmat + 9 * geom)));
      const std::array<double, 4> quat = {turn.w(), turn.x(), turn.y(), turn.z()};
      element += attribute("pos", list(at_m.data(), 3)) + attribute("quat", list(quat.data(), 4)) +
                 attribute("size", list(m_.geom_size + 3 * geom, 3));
      const bool alone = parts_.geoms.empty() && type == mjGEOM_SPHERE && at_m.norm() < 1e-6;
      parts_.sphere_radius_m = alone ? m_.geom_size[3 * geom] : 0.0;
    }
    if (const int id = m_.geom_matid[geom]; id >= 0) {
      const bool on_mesh = type == mjGEOM_MESH && m_.mesh_texcoordadr[m_.geom_dataid[geom]] >= 0;
      element += attribute("material", material(id, on_mesh));
    }
    element += attribute("rgba", list(m_.geom_rgba + 4 * geom, 4)) +
               attribute("group", std::to_string(m_.geom_group[geom])) +
               " contype=\"0\" conaffinity=\"0\"/>\n";
    parts_.geoms += element;
  }

  static const char* mju_type_name(int type) {
    switch (type) {
      case mjGEOM_PLANE:
        return "plane";
      case mjGEOM_SPHERE:
        return "sphere";
      case mjGEOM_CAPSULE:
        return "capsule";
      case mjGEOM_ELLIPSOID:
        return "ellipsoid";
      case mjGEOM_CYLINDER:
        return "cylinder";
      case mjGEOM_BOX:
        return "box";
      default:
        return "mesh";
    }
  }

  /// The mesh of a geom, at its place.
  std::string mesh_of(int geom) {
    const int id = m_.geom_dataid[geom];
    const Vector3d at_m = Eigen::Map<const Vector3d>(data_->geom_xpos + 3 * geom);
    const Eigen::Matrix3d turn = Eigen::Map<const RowMajor>(data_->geom_xmat + 9 * geom);
    TriangleMesh mesh;
    const float* const points = m_.mesh_vert + 3 * m_.mesh_vertadr[id];
    for (int i = 0; i < m_.mesh_vertnum[id]; ++i) {
      mesh.points_m.emplace_back(turn * Eigen::Map<const Eigen::Vector3f>(points + 3 * i).cast<double>() +
                                 at_m);
    }
    const bool textured = m_.mesh_texcoordadr[id] >= 0;
    for (int face = m_.mesh_faceadr[id]; face < m_.mesh_faceadr[id] + m_.mesh_facenum[id]; ++face) {
      std::array<TriangleMesh::Corner, 3> corners;
      for (int k = 0; k < 3; ++k) {
        TriangleMesh::Corner& corner = corners[static_cast<std::size_t>(k)];
        corner.point = m_.mesh_face[3 * face + k];
        if (!textured) continue;
        const float* const texel = m_.mesh_texcoord + 2 * (m_.mesh_texcoordadr[id] + face_texel(m_, face, k));
        corner.texel = static_cast<int>(mesh.texels.size());
        mesh.texels.emplace_back(texel[0], texel[1]);
      }
      mesh.triangles.push_back(corners);
    }
    const std::string place = path_ + ": mesh " + name_in(m_, mjOBJ_MESH, id);
    if (use_ == ModelUse::object) {
      check_surface(mesh, place);
    } else if (mesh.triangles.size() > most_triangles) {
      throw InputError(place, std::to_string(mesh.triangles.size()) + " triangles",
                       "at most " + std::to_string(most_triangles));
    }
    parts_.sphere_radius_m = parts_.geoms.empty() ? saccade::sphere_radius_m(mesh) : 0.0;
    const std::string name = prefix_ + "_mesh_" + std::to_string(geom);
    parts_.assets += mesh_mjcf(mesh, name);
    return name;
  }

  /// `on_mesh`: for texture coordinates of a mesh, which texrepeat and texuniform do not scale before MuJoCo 3.12.
  std::string material(int id, bool on_mesh) {
    const std::string name = prefix_ + (on_mesh ? "_mesh_material_" : "_material_") + std::to_string(id);
    if (!materials_.insert(name).second) return name;
    std::string element = "<material name=\"" + name + "\"";
    if (const int texture_id = material_texture(m_, id); texture_id >= 0) {
      element += attribute("texture", texture(texture_id));
      if (!on_mesh) {
        element += attribute("texrepeat", list(m_.mat_texrepeat + 2 * id, 2)) +
                   attribute("texuniform", m_.mat_texuniform[id] != 0 ? "true" : "false");
      }
    }
    parts_.assets += element + attribute("emission", list(m_.mat_emission + id, 1)) +
                     attribute("specular", list(m_.mat_specular + id, 1)) +
                     attribute("shininess", list(m_.mat_shininess + id, 1)) +
                     attribute("rgba", list(m_.mat_rgba + 4 * id, 4)) + "/>\n";
    return name;
  }

  std::string texture(int id) {
    const std::string name = prefix_ + "_texture_" + std::to_string(id);
    if (!textures_.insert(id).second) return name;
    TextureImage image{name, static_cast<int>(m_.tex_width[id]), static_cast<int>(m_.tex_height[id]), {}};
    const int channels = texture_channels(m_, id);
    if (channels < 3)
      refuse("the texture " + name_in(m_, mjOBJ_TEXTURE, id) + " in grey", "a texture in colour");
    const mjtByte* texel = texels_of(m_, id);
    image.rgb.reserve(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    for (int i = 0; i < image.width * image.height; ++i, texel += channels) {
      image.rgb.insert(image.rgb.end(), texel, texel + 3);
    }
    parts_.assets += texture_mjcf(image, m_.tex_type[id] != mjTEXTURE_2D);
    parts_.textures.push_back(std::move(image));
    return name;
  }

  void add_light(int light) {
    const LightKind kind = light_kind(m_, light);
    if (kind != LightKind::directional && kind != LightKind::spot) {
      refuse("the light " + name_in(m_, mjOBJ_LIGHT, light) + " that MuJoCo's renderer does not draw",
             "lights of the types directional and spot");
    }
    parts_.lights += "<light name=\"" + prefix_ + "_light_" + std::to_string(light) + "\"" +
                     attribute("directional", kind == LightKind::directional ? "true" : "false") +
                     attribute("pos", list(data_->light_xpos + 3 * light, 3)) +
                     attribute("dir", list(data_->light_xdir + 3 * light, 3)) +
                     attribute("attenuation", list(m_.light_attenuation + 3 * light, 3)) +
                     attribute("cutoff", list(m_.light_cutoff + light, 1)) +
                     attribute("exponent", list(m_.light_exponent + light, 1)) +
                     attribute("ambient", list(m_.light_ambient + 3 * light, 3)) +
                     attribute("diffuse", list(m_.light_diffuse + 3 * light, 3)) +
                     attribute("specular", list(m_.light_specular + 3 * light, 3)) +
                     " castshadow=\"false\"/>\n";
  }

  const mjModel& m_;
  const std::string& path_;
  const std::string& prefix_;
  ModelUse use_;
  MjDataPtr data_;
  ModelParts parts_;
  double farthest_m_ = 0.0;
  std::set<std::string> materials_;
  std::set<int> textures_;
};

}  // namespace

ModelParts read_model_file(const std::string& path, const std::string& prefix, ModelUse use) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path, "", "a readable MJCF file");
  std::array<char, 1000> message{};
  const MjModelPtr model(mj_loadXML(path.c_str(), nullptr, message.data(), static_cast<int>(message.size())));
  if (!model) throw InputError(path, in_one_line(message.data()), "a valid MJCF model");
  return Converter(*model, path, prefix, use).parts();
}

MjModelPtr compile_mjcf_text(const std::string& mjcf, const std::string& place,
                             const std::string& expectation) {
  MjVfsPtr vfs(new mjVFS);
  mj_defaultVFS(vfs.get());
  if (!add_to_vfs(vfs.get(), "text.xml", mjcf)) throw RunError("MuJoCo rejects the text of a model");
  std::array<char, 1000> message{};
  MjModelPtr model(mj_loadXML("text.xml", vfs.get(), message.data(), static_cast<int>(message.size())));
  if (!model) throw InputError(place, in_one_line(message.data()), expectation);
  return model;
}

}  // namespace saccade
