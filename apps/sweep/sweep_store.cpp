#include "apps/sweep/sweep_store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/sweep/metrics_numbers.h"
#include "core/config.h"
#include "core/error.h"
#include "evaluation/report/gnuplot.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* schema = R"(
CREATE TABLE sweep(key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE axes(number INTEGER PRIMARY KEY, key TEXT NOT NULL);
CREATE TABLE report_metrics(number INTEGER PRIMARY KEY, name TEXT NOT NULL);
CREATE TABLE runs(run INTEGER PRIMARY KEY, id TEXT NOT NULL, seed INTEGER NOT NULL, status TEXT NOT NULL, failure TEXT);
CREATE TABLE parameters(run INTEGER, key TEXT, value, PRIMARY KEY(run, key)) WITHOUT ROWID;
CREATE TABLE metrics(run INTEGER, name TEXT, value REAL, PRIMARY KEY(run, name)) WITHOUT ROWID;
CREATE TABLE curves(run INTEGER, detector TEXT, points TEXT, PRIMARY KEY(run, detector)) WITHOUT ROWID;
CREATE TABLE times(run INTEGER, name TEXT, value REAL, PRIMARY KEY(run, name)) WITHOUT ROWID;
CREATE INDEX runs_by_id ON runs(id);
)";

/// Runs `work` and converts exceptions of SQLite to DiskFull and RunError.
template <class Work>
auto guarded(const fs::path& path, const Work& work) {
  try {
    return work();
  } catch (const SQLite::Exception& error) {
    const std::string message = path.string() + ": " + error.what();
    if (error.getErrorCode() == SQLITE_FULL || error.getErrorCode() == SQLITE_IOERR) throw DiskFull(message);
    throw RunError(message);
  }
}

void bind_value(SQLite::Statement& statement, int index, const std::string& text) {
  const auto number = number_in(text);
  constexpr double exact = 9e15;
  if (number && *number == std::floor(*number) && std::abs(*number) < exact) {
    statement.bind(index, static_cast<std::int64_t>(*number));
  } else if (number) {
    statement.bind(index, *number);
  } else {
    statement.bind(index, text);
  }
}

template <class Key, class Value>
void insert(SQLite::Database& database, const char* into, const Key& key, const Value& value) {
  SQLite::Statement statement(database, std::string("INSERT INTO ") + into + " VALUES(?, ?)");
  statement.bind(1, key);
  statement.bind(2, value);
  statement.exec();
}

void insert_plan(SQLite::Database& database, const SweepPlan& plan) {
  const SweepConfig& config = plan.config;
  insert(database, "sweep", "name", config.name);
  insert(database, "sweep", "description", config.description);
  insert(database, "sweep", "scenario", config.scenario.filename().string());
  insert(database, "sweep", "version", plan.version);
  insert(database, "sweep", "worst", config.report.worst);
  insert(database, "sweep", "worst_is", std::string(word_of(config.report.worst_is)));
  for (std::size_t i = 0; i < config.axes.size(); ++i)
    insert(database, "axes", static_cast<std::int64_t>(i), config.axes[i].key);
  for (std::size_t i = 0; i < plan.metrics.size(); ++i)
    insert(database, "report_metrics", static_cast<std::int64_t>(i), plan.metrics[i]);
  SQLite::Statement run(database, "INSERT INTO runs VALUES(?, ?, ?, 'waiting', NULL)");
  SQLite::Statement parameter(database, "INSERT INTO parameters VALUES(?, ?, ?)");
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    const auto number = static_cast<std::int64_t>(i + 1);
    run.bind(1, number);
    run.bind(2, plan.runs[i].id);
    run.bind(3, plan.runs[i].seed);
    run.exec();
    run.reset();
    for (std::size_t a = 0; a < config.axes.size(); ++a) {
      parameter.bind(1, number);
      parameter.bind(2, config.axes[a].key);
      bind_value(parameter, 3, config.axes[a].values[plan.runs[i].values[a]].text);
      parameter.exec();
      parameter.reset();
    }
  }
}

void insert_numbers(SQLite::Database& database, const char* table, std::int64_t run,
                    const std::vector<std::pair<std::string, std::optional<double>>>& numbers) {
  SQLite::Statement statement(database, std::string("INSERT OR REPLACE INTO ") + table + " VALUES(?, ?, ?)");
  for (const auto& [name, value] : numbers) {
    statement.bind(1, run);
    statement.bind(2, name);
    if (value) {
      statement.bind(3, *value);
    } else {
      statement.bind(3);
    }
    statement.exec();
    statement.reset();
  }
}

std::vector<std::int64_t> rows_of(SQLite::Database& database, const std::string& id) {
  SQLite::Statement query(database, "SELECT run FROM runs WHERE id = ? ORDER BY run");
  query.bind(1, id);
  std::vector<std::int64_t> rows;
  while (query.executeStep()) rows.push_back(query.getColumn(0).getInt64());
  return rows;
}

void set_status(SQLite::Database& database, const std::string& id, const char* status,
                const std::optional<std::string>& failure) {
  SQLite::Statement update(database, "UPDATE runs SET status = ?, failure = ? WHERE id = ?");
  update.bind(1, status);
  if (failure) update.bind(2, *failure);
  update.bind(3, id);
  update.exec();
}

/// Adds the results of one run, if the folder contains any.
void insert_result(SQLite::Database& database, const SweepFolder& folder, const std::string& id) {
  const auto finished = folder.finished(id);
  if (!finished) return;
  const fs::path metrics = folder.run(id) / "metrics.json";
  if (!fs::exists(metrics)) {
    std::string failure = text_of_file(folder.run(id) / "failure.txt");
    failure.erase(std::find(failure.begin(), failure.end(), '\n'), failure.end());
    set_status(database, id, "failed", failure);
    return;
  }
  MetricsNumbers numbers = metrics_numbers(text_of_file(metrics), metrics.string());
  using Seconds = std::chrono::duration<double>;
  const auto since_1970 = std::chrono::file_clock::to_sys(*finished).time_since_epoch();
  numbers.times.emplace_back("finished", std::chrono::duration_cast<Seconds>(since_1970).count());
  set_status(database, id, "done", std::nullopt);
  for (const std::int64_t run : rows_of(database, id)) {
    insert_numbers(database, "metrics", run, numbers.metrics);
    insert_numbers(database, "times", run, numbers.times);
    SQLite::Statement curve(database, "INSERT OR REPLACE INTO curves VALUES(?, ?, ?)");
    for (const auto& [detector, points] : numbers.curves) {
      curve.bind(1, run);
      curve.bind(2, detector);
      curve.bind(3, points);
      curve.exec();
      curve.reset();
    }
  }
}

std::vector<std::string> column(SQLite::Database& database, const std::string& query) {
  SQLite::Statement statement(database, query);
  std::vector<std::string> values;
  while (statement.executeStep()) values.push_back(statement.getColumn(0).getString());
  return values;
}

/// As it was bound: a number in its shortest text.
std::string text_of(const SQLite::Column& value) {
  if (value.isNull()) return {};
  return value.isFloat() || value.isInteger() ? saccade::text_of(value.getDouble()) : value.getString();
}

std::string setting(SQLite::Database& database, const std::string& key) {
  SQLite::Statement query(database, "SELECT value FROM sweep WHERE key = ?");
  query.bind(1, key);
  return query.executeStep() ? query.getColumn(0).getString() : std::string();
}

std::vector<CurvePoint> curve_of(const std::string& points) {
  std::vector<CurvePoint> curve;
  for (const Json& point : Json::parse(points)) {
    curve.push_back({.threshold = point.at(0).get<double>(),
                     .precision = point.at(1).get<double>(),
                     .recall = point.at(2).get<double>()});
  }
  return curve;
}

}  // namespace

void SweepStore::create(const SweepFolder& folder, const SweepPlan& plan) {
  fs::path part = folder.table();
  part += ".part";
  std::error_code error;
  fs::remove(part, error);
  guarded(part, [&] {
    SQLite::Database database(part.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    database.exec("PRAGMA journal_mode = OFF");
    SQLite::Transaction transaction(database);
    database.exec(schema);
    insert_plan(database, plan);
    std::set<std::string> seen;
    for (const PlannedRun& run : plan.runs) {
      if (seen.insert(run.id).second) insert_result(database, folder, run.id);
    }
    transaction.commit();
  });
  fs::rename(part, folder.table(), error);
  if (error) throw RunError(folder.table().string() + ": cannot be created: " + error.message());
  fs::path journal = folder.table();
  journal += "-journal";
  fs::remove(journal, error);  // of the table that was there
}

SweepStore::SweepStore(const SweepFolder& folder) : folder_(folder) {
  constexpr int wait_ms = 10'000;
  if (!fs::exists(folder.table())) {
    throw InputError(folder.path().string(), "no sweep.sqlite", "the folder of a sweep");
  }
  database_ = guarded(folder.table(), [&] {
    return std::make_unique<SQLite::Database>(folder.table().string(), SQLite::OPEN_READWRITE, wait_ms);
  });
}

SweepStore::~SweepStore() = default;

void SweepStore::add(const std::vector<std::string>& ids) {
  guarded(folder_.table(), [&] {
    SQLite::Transaction transaction(*database_);
    for (const std::string& id : ids) insert_result(*database_, folder_, id);
    transaction.commit();
  });
}

std::string SweepStore::name() const {
  return guarded(folder_.table(), [&] { return setting(*database_, "name"); });
}

std::vector<std::string> SweepStore::ids() const {
  return guarded(folder_.table(), [&] { return column(*database_, "SELECT id FROM runs ORDER BY run"); });
}

std::int64_t SweepStore::count(const std::string& status) const {
  return guarded(folder_.table(), [&] {
    SQLite::Statement query(*database_, "SELECT count(*) FROM runs WHERE status = ?");
    query.bind(1, status);
    query.executeStep();
    return query.getColumn(0).getInt64();
  });
}

std::string SweepStore::csv(bool times) const {
  return guarded(folder_.table(), [&] {
    const std::vector<std::string> axes = column(*database_, "SELECT key FROM axes ORDER BY number");
    std::vector<std::pair<const char*, std::vector<std::string>>> groups = {
        {"metrics", column(*database_, "SELECT DISTINCT name FROM metrics ORDER BY name")}};
    if (times) {
      groups.emplace_back("times", column(*database_, "SELECT DISTINCT name FROM times ORDER BY name"));
    }
    std::string text = "run,id,status,failure";
    for (const std::string& axis : axes) text += "," + csv_field(axis);
    for (const auto& [table, names] : groups)
      for (const std::string& name : names) text += "," + csv_field(name);
    text += "\n";
    SQLite::Statement runs(*database_, "SELECT run, id, status, failure FROM runs ORDER BY run");
    SQLite::Statement parameter(*database_, "SELECT value FROM parameters WHERE run = ? AND key = ?");
    while (runs.executeStep()) {
      const std::int64_t run = runs.getColumn(0).getInt64();
      text += fmt::format("{},{},{},{}", run, runs.getColumn(1).getString(), runs.getColumn(2).getString(),
                          csv_field(runs.getColumn(3).getString()));
      for (const std::string& axis : axes) {
        parameter.bind(1, run);
        parameter.bind(2, axis);
        parameter.executeStep();
        text += "," + csv_field(text_of(parameter.getColumn(0)));
        parameter.reset();
      }
      for (const auto& [table, names] : groups) {
        SQLite::Statement query(*database_,
                                std::string("SELECT name, value FROM ") + table + " WHERE run = ?");
        query.bind(1, run);
        std::map<std::string, std::string> values;
        while (query.executeStep()) values[query.getColumn(0).getString()] = text_of(query.getColumn(1));
        for (const std::string& name : names) text += "," + values[name];
      }
      text += "\n";
    }
    return text;
  });
}

SweepTable SweepStore::table() const {
  return guarded(folder_.table(), [&] {
    SweepTable table;
    table.name = setting(*database_, "name");
    table.description = setting(*database_, "description");
    table.scenario = setting(*database_, "scenario");
    table.version = setting(*database_, "version");
    table.worst = static_cast<std::size_t>(std::stoul(setting(*database_, "worst")));
    table.lowest_is_worst = setting(*database_, "worst_is") == word_of(WorstValue::lowest);
    table.axes = column(*database_, "SELECT key FROM axes ORDER BY number");
    table.metrics = column(*database_, "SELECT name FROM report_metrics ORDER BY number");
    SQLite::Statement runs(*database_, "SELECT run, id, status, failure FROM runs ORDER BY run");
    SQLite::Statement parameter(*database_, "SELECT value FROM parameters WHERE run = ? AND key = ?");
    SQLite::Statement metric(*database_, "SELECT value FROM metrics WHERE run = ? AND name = ?");
    SQLite::Statement curves(*database_, "SELECT detector, points FROM curves WHERE run = ?");
    while (runs.executeStep()) {
      SweepRow row;
      row.run = runs.getColumn(0).getInt64();
      row.id = runs.getColumn(1).getString();
      row.status = runs.getColumn(2).getString();
      row.failure = runs.getColumn(3).getString();
      for (const std::string& axis : table.axes) {
        parameter.bind(1, row.run);
        parameter.bind(2, axis);
        parameter.executeStep();
        row.values.push_back(text_of(parameter.getColumn(0)));
        parameter.reset();
      }
      for (const std::string& name : table.metrics) {
        metric.bind(1, row.run);
        metric.bind(2, name);
        const bool there = metric.executeStep() && !metric.getColumn(0).isNull();
        row.metrics.push_back(there ? std::optional(metric.getColumn(0).getDouble()) : std::nullopt);
        metric.reset();
      }
      curves.bind(1, row.run);
      while (curves.executeStep())
        row.curves.emplace_back(curves.getColumn(0).getString(), curve_of(curves.getColumn(1).getString()));
      curves.reset();
      table.rows.push_back(std::move(row));
    }
    return table;
  });
}

}  // namespace saccade
