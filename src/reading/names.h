#pragma once

/// Names that are mistaken for others: the words that help.

#include <map>
#include <string>
#include <vector>

namespace planar_chain {

/// Numbers of links or joints by name.
using Indices = std::map<std::string, int>;

/// Returns the one of `names` that `text` is most likely a misspelling of: at most a third of its letters
/// are missing, added, replaced or swapped with the next one. Empty if there is none.
std::string closest(const std::string& text, const std::vector<std::string>& names);

/// `expected`, with " (did you mean upper?)" if `text` is most likely a misspelling of one of `names`.
std::string orClosest(const std::string& expected, const std::string& text,
                      const std::vector<std::string>& names);

/// "a, b and c"
std::string listed(const std::vector<std::string>& words);

/// The names in the order of their numbers: "rope_2, rope_10". Cut, with "…", after about `most` letters.
std::string inOrder(const Indices& names, std::size_t most);

/// Returns the expected part of a fault for a `text` that is none of `names`: "a joint of the chain (did you
/// mean upper_joint?)" if it is close to one, or is one of `others` with the same number, such as the joint's
/// link. Else "a joint of the chain (upper_joint, lower_joint)". what: "joint".
std::string oneOf(const std::string& what, const std::string& text, const Indices& names,
                  const Indices* others = nullptr);

}  // namespace planar_chain
