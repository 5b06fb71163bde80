"""The coordinates x of a chain, one for each joint, as in include/planar_chain/chain.h."""

NONE = -1


class Coordinates:
    """x_i is the angle of the body behind a revolute joint, from the base, or the displacement of a prismatic one:

        q_i = x_i − x_k with k = inner[i], or x_i where that is NONE: of prismatic joints and of the first revolute one

    revolute, prismatic: the joints of this kind. turner: of each body the revolute joint whose x is the body's angle; NONE: it
    turns with the base. All count from 0."""

    def __init__(self, are_prismatic):
        self.prismatic = [i for i, is_prismatic in enumerate(are_prismatic) if is_prismatic]
        self.revolute = [i for i, is_prismatic in enumerate(are_prismatic) if not is_prismatic]
        self.turner, self.inner = [], []
        last = NONE
        for i, is_prismatic in enumerate(are_prismatic):
            self.inner.append(NONE if is_prismatic else last)
            last = last if is_prismatic else i
            self.turner.append(last)

    def outwards(self, i):
        """The j whose x_j contain q_i: row i of T, with x = Tᵀ q."""
        return [j for j in self.revolute if j >= i] if i in self.revolute else [i]

    def turned_by(self, i):
        """The bodies whose angle is x_i; of NONE: those that turn with the base."""
        return [k for k, turner in enumerate(self.turner) if turner == i]
