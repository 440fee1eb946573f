#include "apps/sweep/junit.h"

#include <fmt/format.h>

#include <algorithm>
#include <pugixml.hpp>
#include <sstream>

#include "recording/output_file.h"
#include "session/version.h"

namespace saccade {
namespace {

/// XML has no control characters.
std::string printable(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t'; }, ' ');
  return text;
}

void set(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name).set_value(printable(value).c_str());
}

/// Numbers of test cases.
struct Counts {
  std::size_t cases = 0;
  std::size_t failures = 0;
  std::size_t errors = 0;
  double time_s = 0.0;
  void add(const Counts& other) {
    cases += other.cases;
    failures += other.failures;
    errors += other.errors;
    time_s += other.time_s;
  }
};

Counts counts_of(const ScenarioTest& test) {
  Counts counts;
  counts.cases = std::max<std::size_t>(test.expect.size(), 1);
  if (test.failure) counts.errors = counts.cases;
  for (const JudgedExpectation& judged : test.judged) counts.failures += judged.met() ? 0U : 1U;
  counts.time_s = test.elapsed_s.value_or(0.0);
  return counts;
}

void set_counts(pugi::xml_node node, const Counts& counts) {
  set(node, "tests", std::to_string(counts.cases));
  set(node, "failures", std::to_string(counts.failures));
  set(node, "errors", std::to_string(counts.errors));
  set(node, "time", fmt::format("{:.3f}", counts.time_s));
}

pugi::xml_node append_case(pugi::xml_node suite, const ScenarioTest& test, const std::string& name) {
  const pugi::xml_node node = suite.append_child("testcase");
  set(node, "classname", "saccade." + test.name);
  set(node, "name", name);
  set(node, "file", test.file.string());
  const Counts counts = counts_of(test);
  set(node, "time", fmt::format("{:.3f}", counts.time_s / static_cast<double>(counts.cases)));
  return node;
}

void append_problem(pugi::xml_node node, const char* kind, const std::string& message) {
  pugi::xml_node problem = node.append_child(kind);
  set(problem, "message", message);
  set(problem, "type", node.attribute("name").value());
  problem.text().set(printable(message).c_str());
}

void append_suite(pugi::xml_node suites, const ScenarioTest& test) {
  pugi::xml_node suite = suites.append_child("testsuite");
  set(suite, "name", test.name);
  set_counts(suite, counts_of(test));
  pugi::xml_node properties = suite.append_child("properties");
  const auto property = [&](const char* name, const std::string& value) {
    const pugi::xml_node node = properties.append_child("property");
    set(node, "name", name);
    set(node, "value", value);
  };
  property("version", std::string(version()));
  property("commit", std::string(commit()));
  property("seed", std::to_string(test.seed));
  if (test.expect.empty()) {
    const pugi::xml_node node = append_case(suite, test, "runs to its end");
    if (test.failure) append_problem(node, "error", *test.failure);
  }
  for (std::size_t i = 0; i < test.expect.size(); ++i) {
    const pugi::xml_node node = append_case(suite, test, test.expect[i].metric);
    if (test.failure) {
      append_problem(node, "error", "the run failed: " + *test.failure);
    } else if (!test.judged[i].met()) {
      append_problem(node, "failure", test.judged[i].text());
    }
  }
}

}  // namespace

void write_junit(const std::filesystem::path& path, const std::vector<ScenarioTest>& tests) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  set(declaration, "version", "1.0");
  set(declaration, "encoding", "UTF-8");
  pugi::xml_node suites = document.append_child("testsuites");
  set(suites, "name", "saccade");
  Counts all;
  for (const ScenarioTest& test : tests) all.add(counts_of(test));
  set_counts(suites, all);
  for (const ScenarioTest& test : tests) append_suite(suites, test);
  std::ostringstream text;
  document.save(text, "  ", pugi::format_default, pugi::encoding_utf8);
  write_file(path, text.str());
}

}  // namespace saccade
