// What a drag law may know of a grain, beside its Re and the void fraction around it.
#pragma once

namespace elutria::laws
{

class MeasuredDrag;

struct Form
{
    double sphericity = 1;          // surface of the sphere of equal volume over its own
    double flatness = 1;            // shortest over middle axis, S/I
    double elongation = 1;          // middle over longest axis, I/L
    double densityRatio = 1e3;      // its density over the gas'
    double overMean = 1;            // its size over the Sauter mean of its cell
    const MeasuredDrag* measured = nullptr;     // of its own terminal velocities

    /// Are its axes known, and not a sphere's?
    bool hasAxes() const { return flatness < 1 || elongation < 1; }
};

/// Sphericity of an ellipsoid of these axes, 0 < flatness, elongation <= 1.
double ellipsoidSphericity(double flatness, double elongation);

} // namespace elutria::laws
