#pragma once

#include "core/PeriodicBox.hpp"
#include "impacts/ParticleState.hpp"
#include "parallel/Message.hpp"

#include <vector>

namespace elutria::dem
{

/// Where the particles of a rank fly: a few boxes that hold all their bounds. They follow the
/// particles' speeds and ranges and need no mesh.
class Hull
{
public:
    Hull() = default;
    explicit Hull(const std::vector<Bound>& bounds);

    /// Whether a bound reaches into a box, in the given periodic space.
    bool touches(const Bound& bound, const PeriodicBox& space) const
    {
        return touches({bound.centre, {bound.reach, bound.reach, bound.reach}}, space);
    }
    /// The same of a box.
    struct Box
    {
        Vector3 centre, half;            // m
    };
    bool touches(const Box& other, const PeriodicBox& space) const;

    friend Outgoing& operator<<(Outgoing& out, const Hull& hull) { return out << hull.boxes_; }
    friend Incoming& operator>>(Incoming& in, Hull& hull) { return in >> hull.boxes_; }

private:
    static bool touches(const Box& box, const Box& other, const PeriodicBox& space);

    std::vector<Box> boxes_;             // the first holds all the others
};

} // namespace elutria::dem
