#include "dynamics/link_motions.h"

namespace planar_chain {

void linkMotions(const Chain& chain, const double* y, const double* alpha, const Rotation<double>* e,
                 const Vec2d* F, LinkMotion* motions) {
  const int n = chain.size();

  // Outwards: positions, velocities, accelerations of the pins and of the centres of mass.
  Vec2d x, v, a;
  for (int j = 0; j < n; ++j) {
    const Link& link = chain.links()[index(j)];
    const double w = y[n + j];
    const Vec2d R = e[j] * link.com;
    const Vec2d P = e[j] * link.pin;
    LinkMotion& body = motions[j];
    body.innerPin = x;
    body.angle = y[j];
    body.com = x + R;
    body.velocity = v + w * perp(R);
    body.omega = w;
    body.acceleration = a + alpha[j] * perp(R) - (w * w) * R;
    body.alpha = alpha[j];
    x += P;
    v += w * perp(P);
    a += alpha[j] * perp(P) - (w * w) * P;
  }

  // Inwards: the forces in the pins.
  Vec2d next;
  for (int j = n - 1; j >= 0; --j) {
    next += chain.links()[index(j)].mass * (motions[j].acceleration - chain.gravity());
    if (F) next -= F[j];
    motions[j].pinForce = next;
  }
}

}  // namespace planar_chain
