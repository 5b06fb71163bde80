#pragma once

/// Collects the notes of an input. Notes with the same text are one.

#include <map>
#include <string>
#include <vector>

#include "planar_chain/fault.h"

namespace planar_chain {

class Notes {
 public:
  /// Adds a note, or counts it with the first one that has the same text. After `mostNotes` different texts,
  /// further ones are only counted.
  void add(const std::string& path, const std::string& text, int line = 0);
  /// In the order in which the texts came.
  const std::vector<Note>& all() const { return notes_; }

  static constexpr std::size_t mostNotes = 100;

 private:
  std::vector<Note> notes_;
  std::map<std::string, std::size_t> indices_;  ///< in notes_, by text
};

}  // namespace planar_chain
