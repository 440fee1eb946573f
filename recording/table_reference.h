#pragma once

#include <string>
#include <vector>

namespace saccade {

/// A column of a table, for `saccade keys TABLE` and docs/columns.md.
struct ColumnReference {
  std::string name;  ///< JOINT_rad stands for a column of each joint
  std::string type;  ///< "number", "whole number", "text", "0 or 1"
  std::string doc;
};

struct TableReference {
  std::string file;  ///< "truth.csv"
  std::vector<ColumnReference> columns;
};

/// The tables of a run folder (recording/run_files.h) with their columns, from what writes and reads them.
[[nodiscard]] std::vector<TableReference> run_tables();

}  // namespace saccade
