#pragma once

/// Reads laws of motion, the start, and settings of a scene.

#include "effects/effect_kind.h"
#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

constexpr int mostLinks = 100000;
constexpr double highestRate = 10000;

/// The law at a key: {amplitude, frequency, phase, offset} or {times, values}. unit: "rad" or "m". `hold`,
/// where it is allowed, is the constant 0.
MotionLaw readLaw(const Section& in, const char* key, const char* unit, bool mayHold);

/// Key `drive` of a link's joint, which gives the angle: q and q̇ are set, and nothing else may be given.
MotionLaw readDrive(const Section& link, const Section& joint, const char* unit, double& q, double& qd);

/// Key `base` of a scene.
BaseLaws readBase(const Section& base);

/// Key `start`. Returns true for a start at rest.
bool readStart(const Section& top);
/// Refuses method taylor where an effect has no Taylor series.
void requireSeries(const Scene& scene, const Section& top);
/// Puts the scene at rest in its equilibrium at t = 0.
void startAtRest(Scene& scene, const Section& top);

/// Returns true if the key is absent or an integer from 1 to mostLinks.
bool takeCount(const Section& in, const char* key, int& target);

/// The map `integrator`, and the one at `publish`. names: nullptr if the links could not be read.
IntegratorSettings readIntegrator(const Section& in);
PublishSettings readPublish(const Section& top, const ChainNames* names);

}  // namespace planar_chain
