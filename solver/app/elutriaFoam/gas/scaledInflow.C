/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "gas/scaledInflow.H"
#include "fixedValueFvPatchFields.H"
#include "IStringStream.H"
#include "OStringStream.H"

namespace Foam
{

namespace
{

//- What the condition would write, to the last bit
dictionary entriesOf(const fvPatchVectorField& condition)
{
    OStringStream os;
    os.precision(17);
    condition.write(os);
    IStringStream is(os.str());
    return dictionary(is);
}


template<class Type>
bool scaleField
(
    dictionary& dict, const word& name, const label size, const scalar factor
)
{
    if (!dict.found(name))
    {
        return false;
    }
    const Field<Type> scaled(factor*Field<Type>(name, dict, size));
    OStringStream os;
    os.precision(17);
    scaled.writeEntry(name, os);
    IStringStream is(os.str());
    dict.merge(dictionary(is));
    return true;
}


//- A rate that does not change in time: a number, or `constant` and a number
bool scaleRate(dictionary& dict, const word& name, const scalar factor)
{
    if (!dict.found(name))
    {
        return false;
    }
    const entry* rate = dict.findEntry(name);
    const token last = rate->isStream() ? rate->stream().last() : token();
    const label tokens = rate->isStream() ? rate->stream().size() : 0;
    const bool constant =
        tokens == 1
     || (tokens == 2 && rate->stream().first() == token(word("constant")));
    if (!constant || !last.isNumber())
    {
        return false;
    }
    dict.set(name, factor*last.number());
    return true;
}

} // End anonymous namespace


autoPtr<fvPatchVectorField> scaledInflow
(
    const fvPatchVectorField& condition,
    const scalar factor
)
{
    dictionary dict(entriesOf(condition));
    const label size = condition.size();
    const bool valued = scaleField<vector>(dict, "value", size, factor);
    const bool known =
        (valued && condition.type() == fixedValueFvPatchVectorField::typeName)
     || scaleField<vector>(dict, "inletVelocity", size, factor)
     || scaleField<scalar>(dict, "refValue", size, factor)
     || scaleRate(dict, "volumetricFlowRate", factor)
     || scaleRate(dict, "massFlowRate", factor);
    if (!known)
    {
        return nullptr;
    }
    return autoPtr<fvPatchVectorField>
    (
        fvPatchVectorField::New
        (
            condition.patch(), condition.internalField(), dict
        ).ptr()
    );
}


} // End namespace Foam
