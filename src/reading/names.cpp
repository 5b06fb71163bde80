#include "reading/names.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace planar_chain {

namespace {

/// The number of letters to add, remove, replace or swap with the next one. Source: the optimal string
/// alignment distance, a restriction of F. J. Damerau, A technique for computer detection and correction of
/// spelling errors (1964).
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replaced});
      const bool isSwapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (isSwapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string closest(const std::string& text, const std::vector<std::string>& names) {
  constexpr std::size_t longest = 64, mostNames = 1000;  // it takes the product of the lengths for each name
  if (text.size() < 3 || text.size() > longest) return "";
  std::size_t least = std::max<std::size_t>(1, text.size() / 3) + 1;
  std::string best;
  for (std::size_t k = 0; k < std::min(names.size(), mostNames); ++k) {
    if (names[k].size() > longest) continue;
    const std::size_t its = distance(text, names[k]);
    if (its >= least) continue;
    least = its;
    best = names[k];
  }
  return best;
}

std::string orClosest(const std::string& expected, const std::string& text,
                      const std::vector<std::string>& names) {
  const std::string meant = closest(text, names);
  return meant.empty() ? expected : expected + " (did you mean " + meant + "?)";
}

std::string listed(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t k = 0; k < words.size(); ++k) {
    list += (k == 0 ? "" : k + 1 < words.size() ? ", " : " and ") + words[k];
  }
  return list;
}

std::string inOrder(const Indices& names, std::size_t most) {
  std::vector<std::pair<int, const std::string*>> sorted;
  for (const auto& [name, number] : names) sorted.emplace_back(number, &name);
  std::sort(sorted.begin(), sorted.end());
  std::string line;
  for (const auto& [number, name] : sorted) {
    if (line.size() > most) return line + ", …";
    line += (line.empty() ? "" : ", ") + *name;
  }
  return line;
}

std::string oneOf(const std::string& what, const std::string& text, const Indices& names,
                  const Indices* others) {
  constexpr std::size_t most = 80;  // letters of the list
  if (names.empty()) return "a " + what + " of the chain, which has none";
  std::string meant;
  const auto other = others ? others->find(text) : Indices::const_iterator();
  if (others && other != others->end()) {
    const auto same = std::find_if(names.begin(), names.end(),
                                   [&](const auto& entry) { return entry.second == other->second; });
    if (same != names.end()) meant = same->first;
  }
  if (meant.empty()) {
    std::vector<std::string> all;
    for (const auto& entry : names) all.push_back(entry.first);
    meant = closest(text, all);
  }
  return "a " + what + " of the chain (" +
         (meant.empty() ? inOrder(names, most) : "did you mean " + meant + "?") + ")";
}

}  // namespace planar_chain
