#pragma once

/// Elements of a URDF and their attributes, with the faults and notes that are found on the way.

#include <tinyxml2.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "model/number_rule.h"
#include "reading/notes.h"
#include "reading/section.h"
#include "scene/urdf_foreign.h"

namespace planar_chain {

/// The faults and notes of a document.
struct Findings {
  std::vector<Fault>& faults;
  Notes& notes;
};

/// An element, or an absent one, which has no attributes.
class Element {
 public:
  using Names = std::initializer_list<const char*>;

  /// line: of the element around it, for an absent one.
  Element(const tinyxml2::XMLElement* at, std::string path, Findings& to, int line = 0)
      : at_(at), path_(std::move(path)), to_(&to), line_(at ? at->GetLineNum() : line) {}

  bool isThere() const { return at_ != nullptr; }
  const tinyxml2::XMLElement& element() const { return *at_; }
  /// The number of faults in the document so far.
  std::size_t faults() const { return to_->faults.size(); }
  const char* attribute(const char* name) const { return at_ ? at_->Attribute(name) : nullptr; }
  /// An attribute as a fault shows it.
  std::string found(const char* name) const { return attribute(name) ? quoted(attribute(name)) : "nothing"; }
  void fault(const std::string& key, const std::string& expected, const std::string& found) const {
    to_->faults.push_back({path_ + "/" + key, expected, found, line_});
  }
  /// Adds a note about this element, or about its attribute `key`.
  void note(const std::string& text, const std::string& key = "") const {
    to_->notes.add(key.empty() ? path_ : path_ + "/" + key, text, line_);
  }
  /// Records a fault: the attribute holds something other than `expected`.
  void fault(const char* attribute, const std::string& expected) const {
    fault(attribute, expected, found(attribute));
  }

  /// Notes each child or attribute with another name as ignored. If it changes the motion, or is a slip of
  /// the pen, it is a fault.
  const Element& of(Names children, Names attributes) const {
    if (!at_) return *this;
    for (auto child = at_->FirstChildElement(); child; child = child->NextSiblingElement()) {
      judge(child->Name(), "element", children);
    }
    for (auto attribute = at_->FirstAttribute(); attribute; attribute = attribute->Next()) {
      judge(attribute->Name(), "attribute", attributes);
    }
    return *this;
  }

  /// The child of that name, which may be absent. A second one is a fault.
  Element only(const char* name) const {
    const tinyxml2::XMLElement* child = at_ ? at_->FirstChildElement(name) : nullptr;
    if (child && child->NextSiblingElement(name)) {
      const int line = child->NextSiblingElement(name)->GetLineNum();
      to_->faults.push_back(
          {path_ + "/" + name, "this element once", "it again in line " + std::to_string(line)});
    }
    return {child, path_ + "/" + name, *to_, line_};
  }

  std::string name(const char* key) const {
    const std::string given = attribute(key) ? attribute(key) : "";
    if (given.empty()) fault(key, "a name");
    return given;
  }

  double number(const char* key, const NumberRule& rule, double absent = missing()) const {
    if (!attribute(key) && rule.holds(absent)) return absent;
    const std::vector<double> numbers = finiteNumbers(key);
    if (numbers.size() == 1 && rule.holds(numbers[0])) return numbers[0];
    const bool isTooLarge = numbers.size() == 1 && numbers[0] > rule.high;
    fault(key, "a finite number" + rule.which + (isTooLarge ? rule.most : ""),
          found(key) + numberNote(attribute(key) ? attribute(key) : ""));
    return missing();
  }

  Eigen::Vector3d three(const char* key, const char* unit, const Eigen::Vector3d& absent) const {
    if (!attribute(key)) return absent;
    const std::vector<double> numbers = finiteNumbers(key);
    if (numbers.size() == 3) return {numbers[0], numbers[1], numbers[2]};
    fault(key, std::string("three finite numbers") + unit);
    return absent;
  }

 private:
  static constexpr double missing() { return std::numeric_limits<double>::quiet_NaN(); }

  /// The numbers between white space; none if one of the words is not a finite number.
  std::vector<double> finiteNumbers(const char* key) const {
    std::istringstream in(attribute(key) ? attribute(key) : "");
    std::vector<double> numbers;
    for (std::string word; in >> word;) {
      const auto number = numberIn(word);
      if (!number || !std::isfinite(*number)) return {};
      numbers.push_back(*number);
    }
    return numbers;
  }

  void judge(const char* given, const char* kind, Names known) const {
    const std::string name = given, path = onOneLine(name);
    if (std::find(known.begin(), known.end(), name) != known.end()) return;
    const auto meant =
        std::find_if(known.begin(), known.end(), [&](const char* other) { return isSlipOf(name, other); });
    const ForeignForce* force = foreignForce(name);
    if (meant != known.end()) {
      fault(path, std::string("the ") + kind + " " + *meant, quoted(name));
    } else if (force && force->isRefused) {
      fault(path,
            std::string("no ") + kind + " of that name, as it changes the motion (" + force->instead + ")",
            quoted(name));
    } else if (force) {
      note(path + " is not read, though it changes the motion (" + force->instead + ")", path);
    } else {
      note("ignored, as <" + onOneLine(at_->Name()) + "> of URDF has no " + kind + " " + path, path);
    }
  }

  const tinyxml2::XMLElement* at_;
  std::string path_;
  Findings* to_;
  int line_;
};

}  // namespace planar_chain
