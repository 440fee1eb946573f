#include "head/ikin_links.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "core/units.h"

namespace saccade {
namespace {

struct LinkRow {
  double a_m = 0.0, d_m = 0.0, alpha_deg = 0.0, offset_deg = 0.0, min_deg = 0.0, max_deg = 0.0;
  std::optional<double> blocked_deg;

  [[nodiscard]] bool same_but_d(const LinkRow& other) const {
    return a_m == other.a_m && alpha_deg == other.alpha_deg && offset_deg == other.offset_deg &&
           blocked_deg == other.blocked_deg;
  }
};

struct IkinLimb {
  std::array<double, 16> h0 = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  std::array<double, 16> hn = h0;
  std::vector<LinkRow> rows;
};

class IkinParser {
 public:
  explicit IkinParser(const IkinText& source) : source_(source) {
    std::string line;
    std::string group;
    for (const char c : source.text + "\n") {
      if (c != '\n') {
        line += c;
        continue;
      }
      ++line_number_;
      read_line(line.substr(0, std::min(line.find('#'), line.find("//"))), group);
      line.clear();
    }
    if (!count_) fail("no numLinks", "the number of links");
    if (links_.size() != static_cast<std::size_t>(*count_) || !in_order())
      fail(std::to_string(links_.size()) + " links", std::to_string(*count_) + ": link_0, link_1 and so on");
    for (const auto& [number, row] : links_) limb_.rows.push_back(row);
  }

  [[nodiscard]] const IkinLimb& limb() const { return limb_; }

 private:
  static constexpr int most_links = 24;

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(source_.name + (count_ || !links_.empty() ? ":" + std::to_string(line_number_) : ""),
                     found, expected);
  }

  static std::vector<std::string> words_of(std::string_view text) {
    std::vector<std::string> words;
    std::string word;
    const auto end_word = [&] {
      if (!word.empty()) words.push_back(std::move(word));
      word.clear();
    };
    for (const char c : text) {
      const bool blank = c == ' ' || c == '\t' || c == '\r';
      if (blank || c == '(' || c == ')' || c == '[' || c == ']') end_word();
      if (!blank && (c == '(' || c == ')' || c == '[' || c == ']')) {
        words.emplace_back(1, c);
      } else if (!blank) {
        word += c;
      }
    }
    end_word();
    return words;
  }

  double number(const std::string& word) const {
    double value = 0.0;
    const char* const begin = word.data() + (word.starts_with('+') ? 1 : 0);
    const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      fail(word, "a finite number");
    return value;
  }

  void read_line(const std::string& line, std::string& group) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) return;
    if (words.front() == "[") {
      group = words.size() > 1 ? words[1] : "";
      if (group.starts_with("link_")) (void)row(group);
      return;
    }
    if (group.starts_with("link_")) {
      if (words.size() < 2) fail(line, "a key and a number");
      set(row(group), words[0], words[1] == "(" && words.size() > 2 ? words[2] : words[1]);
    } else if (words[0] == "H0" || words[0] == "HN") {
      set_matrix(words[0] == "H0" ? limb_.h0 : limb_.hn, words);
    } else if (words[0] == "numLinks" && words.size() > 1) {
      const double count = number(words[1]);
      if (!(count >= 1.0 && count <= most_links && count == std::round(count)))
        fail(words[1], "a whole number of links, 1 to " + std::to_string(most_links));
      count_ = static_cast<int>(count);
    } else if (words[0].starts_with("link_")) {
      LinkRow& link = row(words[0]);
      for (std::size_t i = 1; i + 3 < words.size(); i += 4) {
        if (words[i] != "(" || words[i + 3] != ")") fail(line, "options like (A 0.032)");
        set(link, words[i + 1], words[i + 2]);
      }
      if (words.size() % 4 != 1) fail(line, "options like (A 0.032)");
    }
  }

  LinkRow& row(const std::string& name) {
    int number = -1;
    const char* const begin = name.data() + 5;
    const auto [end, error] = std::from_chars(begin, name.data() + name.size(), number);
    if (error != std::errc() || end != name.data() + name.size() || number < 0 || number >= most_links)
      fail(name, "link_0 to link_" + std::to_string(most_links - 1));
    return links_[number];
  }

  void set(LinkRow& link, const std::string& key, const std::string& word) const {
    const double value = number(word);
    if (key == "A")
      link.a_m = value;
    else if (key == "D")
      link.d_m = value;
    else if (key == "alpha")
      link.alpha_deg = value;
    else if (key == "offset")
      link.offset_deg = value;
    else if (key == "min")
      link.min_deg = value;
    else if (key == "max")
      link.max_deg = value;
    else if (key == "blocked")
      link.blocked_deg = value;
    else
      fail(key, "A, D, alpha, offset, min, max or blocked");
  }

  void set_matrix(std::array<double, 16>& matrix, const std::vector<std::string>& words) const {
    std::vector<double> values;
    for (std::size_t i = 1; i < words.size(); ++i) {
      if (words[i] != "(" && words[i] != ")") values.push_back(number(words[i]));
    }
    if (values.size() != matrix.size())
      fail(std::to_string(values.size()) + " numbers", "16 numbers, by rows");
    std::ranges::copy(values, matrix.begin());
  }

  [[nodiscard]] bool in_order() const {
    int next = 0;
    return std::ranges::all_of(links_, [&](const auto& link) { return link.first == next++; });
  }

  const IkinText& source_;
  IkinLimb limb_;
  std::map<int, LinkRow> links_;
  std::optional<int> count_;
  int line_number_ = 0;
};

DescribedLink link_of(const LinkRow& row) {
  DescribedLink link;
  link.a_m = row.a_m;
  link.d_m = row.d_m;
  link.alpha_deg = row.alpha_deg;
  link.offset_deg = row.offset_deg + row.blocked_deg.value_or(0.0);
  return link;
}

void split(const std::array<double, 16>& h, std::array<double, 9>& rotation, Eigen::Vector3d& position_m) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) rotation[3 * i + j] = h[4 * i + j];
    position_m[static_cast<Eigen::Index>(i)] = h[4 * i + 3];
  }
}

/// The joint of each row that is not blocked.
std::vector<std::string> joint_names_of(std::size_t rows) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < rows; ++i) {
    names.push_back(rows + 1 == joint_names.size() ? std::string(joint_names[i])
                                                   : "joint_" + std::to_string(i));
  }
  return names;
}

}  // namespace

HeadDescription description_of_ikin(const IkinText& left, const IkinText* right) {
  const IkinLimb first = IkinParser(left).limb();
  const IkinLimb second = right != nullptr ? IkinParser(*right).limb() : first;
  const std::size_t count = first.rows.size();
  if (second.rows.size() != count || second.h0 != first.h0)
    throw InputError(right->name, std::to_string(second.rows.size()) + " links",
                     "the H0 and the number of links of " + left.name);
  HeadDescription head;
  split(first.h0, head.base_rotation, head.base_position_m);
  split(first.hn, head.left_eye.end_rotation, head.left_eye.end_position_m);
  if (right != nullptr) {
    head.right_eye.emplace();
    split(second.hn, head.right_eye->end_rotation, head.right_eye->end_position_m);
  }

  const std::vector<std::string> names = joint_names_of(count);
  const bool is_icub = count + 1 == joint_names.size();
  std::size_t common = 0;
  while (right != nullptr && common + 1 < count && first.rows[common].same_but_d(second.rows[common]) &&
         first.rows[common].d_m == second.rows[common].d_m)
    ++common;
  if (right == nullptr) common = count;
  const bool beside = common + 1 < count && first.rows[common].same_but_d(second.rows[common]);

  for (std::size_t i = 0; i < count; ++i) {
    const LinkRow& row = first.rows[i];
    const bool last = i + 1 == count;
    const bool coupled = last && right != nullptr;
    if (!row.blocked_deg) {
      DescribedJoint joint;
      joint.role = is_icub && i < 3 ? JointRole::torso : i + 2 < count ? JointRole::neck : JointRole::eye;
      joint.min_deg = row.min_deg;
      joint.max_deg = row.max_deg;
      joint.max_speed_deg_s = joint.role == JointRole::eye ? 350.0 : 100.0;
      joint.bandwidth_hz = joint.role == JointRole::eye ? 27.0 : 10.0;
      head.joints.emplace_back(names[i], joint);
      if (coupled) {
        joint.min_deg = 0.0;
        joint.max_deg = 50.0;
        head.joints.emplace_back(is_icub ? "eyes_vergence" : "vergence", joint);
      }
    }
    const auto turned = [&](const LinkRow& from, double half_vergence) {
      DescribedLink link = link_of(from);
      if (from.blocked_deg) return link;
      link.joint = names[i];
      if (coupled) {
        link.second_joint = is_icub ? "eyes_vergence" : "vergence";
        link.second_share = half_vergence;
      }
      return link;
    };
    if (i < common || (beside && i == common)) {
      DescribedLink link = turned(row, 0.5);
      if (beside && i == common) link.d_m = 0.0;
      head.links.emplace_back(names[i], link);
      continue;
    }
    const auto add = [&](DescribedEye& eye, const IkinLimb& limb, const char* side, double half_vergence) {
      DescribedLink link = turned(limb.rows[i], half_vergence);
      if (beside && i == common + 1) {
        // D of the row before, in the frame after that row.
        const LinkRow& before = limb.rows[common];
        const Eigen::AngleAxisd back(-before.alpha_deg * rad_per_deg, Eigen::Vector3d::UnitX());
        link.before_m = back * Eigen::Vector3d(0.0, 0.0, before.d_m);
      }
      eye.links.emplace_back(side + names[i], link);
    };
    add(head.left_eye, first, "l_", 0.5);
    if (right != nullptr) add(*head.right_eye, second, "r_", -0.5);
  }
  return head;
}

}  // namespace saccade
