#include "config/urdf_head.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "config/xml_file.h"

namespace saccade {
namespace {

/// The numbers of an attribute; none unless there are `count` finite ones.
std::optional<std::vector<double>> numbers_in(std::string_view text, std::size_t count) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  const auto skip_blanks = [&] {
    at = std::find_if(at, end, [](char c) { return c != ' ' && c != '\t' && c != '\n' && c != '\r'; });
  };
  for (skip_blanks(); at != end; skip_blanks()) {
    if (*at == '+' && at + 1 != end && at[1] != '-') ++at;
    double value = 0.0;
    const auto [after, error] = std::from_chars(at, end, value);
    const bool ended = after == end || *after == ' ' || *after == '\t' || *after == '\n' || *after == '\r';
    if (error != std::errc() || !ended || !std::isfinite(value)) return std::nullopt;
    numbers.push_back(value);
    at = after;
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

class UrdfChain {
 public:
  explicit UrdfChain(const ChainRequest& request) : request_(request), file_(request.path, "robot") {
    read_tree();
    file_.throw_if_any();
    const std::vector<pugi::xml_node> left = path_to(request.camera, "head.camera");
    std::vector<pugi::xml_node> right;
    if (request.right_camera) right = path_to(*request.right_camera, "head.right_camera");
    file_.throw_if_any();
    require_chain(left, right);
    place(left, right);
    file_.throw_if_any();
  }

  [[nodiscard]] PlacedChain chain() const { return chain_; }

 private:
  void read_tree() {
    for (const pugi::xml_node element : file_.root().children()) {
      const std::string_view kind = element.name();
      if (kind.starts_with("xacro:")) {
        file_.add(element, "a macro of xacro", "URDF without macros, as `xacro FILE` prints it");
        return;
      }
      if (kind != "link" && kind != "joint") continue;
      const std::string name = element.attribute("name").value();
      if (name.empty()) {
        file_.add(element, "no name", "an attribute name");
      } else if (!(kind == "link" ? links_ : joints_).emplace(name, element).second) {
        file_.add(element, "a name that is taken", "each name once");
      }
    }
    if (links_.empty()) file_.add("no <link>", "a robot of links and joints");
    for (const auto& [name, joint] : joints_) {
      for (const char* end : {"parent", "child"}) {
        const pugi::xml_node element = joint.child(end);
        const std::string link = element.attribute("link").value();
        if (!links_.contains(link))
          file_.add(element ? element : joint, link.empty() ? "no " + std::string(end) + " link" : link,
                    "a link of the file as the " + std::string(end) + " of joint " + name);
      }
      const auto [other, first] = above_.emplace(joint.child("child").attribute("link").value(), joint);
      if (!first)
        file_.add(joint, "a second parent of link " + other->first, "one joint that carries each link");
    }
  }

  /// The joints from the base to a link; empty, with a problem added, where they do not connect.
  std::vector<pugi::xml_node> path_to(const std::string& link, const std::string& key) {
    if (!links_.contains(link)) {
      file_.add(key + ": " + link, "the name of a link");
      return {};
    }
    if (request_.base && !links_.contains(*request_.base)) {
      file_.add("head.base: " + *request_.base, "the name of a link");
      return {};
    }
    std::vector<pugi::xml_node> path;
    std::string at = link;
    while (!(request_.base && at == *request_.base)) {
      const auto joint = above_.find(at);
      if (joint == above_.end()) break;
      path.push_back(joint->second);
      at = joint->second.child("parent").attribute("link").value();
      if (path.size() > joints_.size()) {
        file_.add(links_.at(link), "a chain of joints that closes on itself", "a tree of links");
        return {};
      }
    }
    if (request_.base && at != *request_.base)
      file_.add(links_.at(link), "a link on " + at, "a link on head.base, " + *request_.base);
    if (!base_.empty() && at != base_)
      file_.add(links_.at(link), "a link on " + at, "a link on " + base_ + ", as the left camera");
    base_ = at;
    std::ranges::reverse(path);
    return path;
  }

  static std::string name_of(const pugi::xml_node& joint) { return joint.attribute("name").value(); }

  void require_chain(const std::vector<pugi::xml_node>& left, const std::vector<pugi::xml_node>& right) {
    std::vector<std::string> order;
    for (const auto* path : {&left, &right}) {
      for (const pugi::xml_node& joint : *path) {
        const std::string name = name_of(joint);
        if (std::ranges::count(request_.joints, name) > 0 && std::ranges::count(order, name) == 0)
          order.push_back(name);
      }
    }
    bool all = true;
    for (const std::string& name : request_.joints) {
      if (std::ranges::count(order, name) > 0) continue;
      all = false;
      if (const auto joint = joints_.find(name); joint != joints_.end())
        file_.add(joint->second, "a joint of head.chain that does not turn the camera",
                  "one between " + base_ + " and " + request_.camera);
      else
        file_.add("head.chain: " + name, "the name of a joint");
    }
    if (all && order != request_.joints) {
      std::string names;
      for (const std::string& name : order) names += (names.empty() ? "" : ", ") + name;
      file_.add("head.chain in another order", "that from the base to the cameras: [" + names + "]");
    }
  }

  Eigen::Vector3d vector_in(const pugi::xml_node& element, const char* name, const Eigen::Vector3d& usual) {
    const pugi::xml_attribute attribute = element.attribute(name);
    if (!attribute) return usual;
    const auto numbers = numbers_in(attribute.value(), 3);
    Eigen::Vector3d vector = numbers ? Eigen::Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]) : usual;
    if (numbers && vector.cwiseAbs().maxCoeff() <= 1e6) return vector;
    file_.add(element, std::string(name) + "=\"" + attribute.value() + "\"",
              "three finite numbers up to 1e6");
    return usual;
  }

  Eigen::Isometry3d origin_of(const pugi::xml_node& joint) {
    const pugi::xml_node origin = joint.child("origin");
    const Eigen::Vector3d rpy = vector_in(origin, "rpy", Eigen::Vector3d::Zero());
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(vector_in(origin, "xyz", Eigen::Vector3d::Zero()));
    pose.rotate(Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()));
    return pose;
  }

  double limit_of(const pugi::xml_node& limit, const char* name, double usual) {
    const pugi::xml_attribute attribute = limit.attribute(name);
    if (!attribute) return usual;
    const auto numbers = numbers_in(attribute.value(), 1);
    if (!numbers) file_.add(limit, std::string(name) + "=\"" + attribute.value() + "\"", "a finite number");
    return numbers ? numbers->front() : usual;
  }

  PlacedJoint placed(const pugi::xml_node& joint, const Eigen::Isometry3d& frame) {
    constexpr double largest_rad_s = 5000.0 * 3.14159265358979323846 / 180.0;
    PlacedJoint result;
    result.name = name_of(joint);
    result.place = file_.place(joint);
    const std::string_view type = joint.attribute("type").value();
    if (type != "revolute" && type != "continuous")
      file_.add(joint, "type=\"" + std::string(type) + "\"", "revolute or continuous in head.chain");
    if (const pugi::xml_node mimic = joint.child("mimic"))
      file_.add(joint, "a joint that mimics " + std::string(mimic.attribute("joint").value()),
                "a joint of its own in head.chain");
    const Eigen::Vector3d axis = vector_in(joint.child("axis"), "xyz", Eigen::Vector3d::UnitX());
    if (axis.norm() < 1e-6) file_.add(joint.child("axis"), "an axis of length 0", "a direction");
    result.axis = frame.linear() * axis.normalized();
    result.point_m = frame.translation();
    if (const pugi::xml_node limit = joint.child("limit")) {
      if (type == "revolute") {
        result.min_rad = limit_of(limit, "lower", 0.0);
        result.max_rad = limit_of(limit, "upper", 0.0);
        if (!(result.min_rad < result.max_rad))
          file_.add(limit, "lower and upper of joint " + result.name + " without a range between them",
                    "lower below upper");
      }
      const double speed_rad_s = limit_of(limit, "velocity", 0.0);
      if (speed_rad_s > 0.0 && speed_rad_s <= largest_rad_s) result.max_speed_rad_s = speed_rad_s;
    }
    return result;
  }

  void place(const std::vector<pugi::xml_node>& left, const std::vector<pugi::xml_node>& right) {
    const std::vector<std::string>& moving = request_.joints;
    std::size_t shared = request_.right_camera ? 0 : left.size();
    while (shared < std::min(left.size(), right.size()) && left[shared] == right[shared]) ++shared;
    chain_.cameras = request_.right_camera ? 2 : 1;
    for (std::size_t e = 0; e < static_cast<std::size_t>(chain_.cameras); ++e) {
      const std::vector<pugi::xml_node>& path = e == 0 ? left : right;
      Eigen::Isometry3d frame(request_.root_from_base);
      for (std::size_t i = 0; i < path.size(); ++i) {
        frame = frame * origin_of(path[i]);
        if (std::ranges::count(moving, name_of(path[i])) == 0) {
          const std::string leader = path[i].child("mimic").attribute("joint").value();
          if (std::ranges::count(moving, leader) > 0)
            file_.add(path[i], "a joint that mimics " + leader, "no such joint between base and camera");
          continue;
        }
        if (e == 1 && i < shared) continue;
        PlacedJoint joint = placed(path[i], frame);
        if (i >= shared) joint.role = JointRole::eye;
        (i < shared ? chain_.common : chain_.eye[e]).push_back(std::move(joint));
      }
      if (!request_.optical) frame.rotate(body_from_optical());
      chain_.root_from_camera[e] = frame;
    }
  }

  const ChainRequest& request_;
  XmlFile file_;
  std::map<std::string, pugi::xml_node> links_, joints_;
  std::map<std::string, pugi::xml_node> above_;  // by link: the joint that carries it
  std::string base_;
  PlacedChain chain_;
};

}  // namespace

PlacedChain chain_of_urdf(const ChainRequest& request) { return UrdfChain(request).chain(); }

}  // namespace saccade
