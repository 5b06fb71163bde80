#pragma once

/// Reads the data files of test/reference: tables with a header line, and scenes.

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "planar_chain/scene_reader.h"

namespace planar_chain::test {

inline std::string readReference(const std::string& file) {
  std::ifstream stream(std::string(REFERENCE_DIR) + "/" + file);
  if (!stream) throw std::runtime_error(file + " cannot be read");
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

inline Scene referenceScene(const std::string& file) {
  return readSceneText(readReference(file));
}

/// One line of a table, by the names of its columns.
class Row {
 public:
  Row(const std::vector<std::string>& names, const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < names.size(); ++i) cells_[names[i]] = cells.at(i);
  }
  const std::string& text(const std::string& column) const { return cells_.at(column); }
  double number(const std::string& column) const { return std::strtod(text(column).c_str(), nullptr); }
  int index(const std::string& column) const { return std::atoi(text(column).c_str()); }

 private:
  std::map<std::string, std::string> cells_;
};

inline std::vector<Row> referenceTable(const std::string& file) {
  std::istringstream lines(readReference(file));
  std::vector<std::string> names;
  std::vector<Row> rows;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::string cell;
    for (const char c : line + ",") {
      if (c == ',') {
        cells.push_back(cell);
        cell.clear();
      } else {
        cell += c;
      }
    }
    if (names.empty()) {
      names = cells;
    } else {
      rows.emplace_back(names, cells);
    }
  }
  return rows;
}

}  // namespace planar_chain::test
