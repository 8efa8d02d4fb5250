/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "feed/Products.H"
#include "foam/foamVersion.H"
#include "Fstream.H"
#include "polyBoundaryMesh.H"

#include <algorithm>

namespace Foam
{

namespace
{

//- Depth of brackets after a token
label depthAfter(const token& t, const label depth)
{
    if (t.isPunctuation())
    {
        switch (t.pToken())
        {
            case token::BEGIN_BLOCK:
            case token::BEGIN_LIST:
                return depth + 1;
            case token::END_BLOCK:
            case token::END_LIST:
                return depth - 1;
            default:
                break;
        }
    }
    return depth;
}


//- The keywords of a dictionary of a file as they are written: of two that are
//  equal, a dictionary that was read knows one
wordList writtenKeywords(const fileName& file, const word& name)
{
    wordList keywords;
    IFstream is(file);
    label depth = 0;
    bool inside = false, begins = true;
    token t;
    while (is.good() && is.read(t).good() && t.good())
    {
        if (t.isWord() && begins && depth == 0)
        {
            inside = t.wordToken() == name;
        }
        else if (t.isWord() && begins && depth == 1 && inside)
        {
            keywords.append(t.wordToken());
        }
        begins =
            t.isPunctuation()
         && (
                t.pToken() == token::END_STATEMENT
             || t.pToken() == token::BEGIN_BLOCK
             || t.pToken() == token::END_BLOCK
            );
        depth = depthAfter(t, depth);
    }
    return keywords;
}


void refuseRepeated(const dictionary& outlets, const dictionary& feed)
{
    wordHashSet seen;
    const fileName& file = feed.name();
    for (const word& product : writtenKeywords(file, "outlets"))
    {
        if (!seen.insert(product))
        {
            FatalIOErrorInFunction(outlets)
                << "outlet " << product << " is there twice, allowed: each"
                << " product once, with all of its patches"
                << exit(FatalIOError);
        }
    }
}

} // End anonymous namespace


// * * * * * * * * * * * * * Private Member Functions  * * * * * * * * * * * //

void Products::readPatches
(
    const dictionary& dict,
    const word& product,
    const polyBoundaryMesh& patches
)
{
    const wordList own(dict.get<wordList>(product));
    if (own.empty())
    {
        FatalIOErrorInFunction(dict)
            << "outlet " << product << " has no patches, allowed: a list of: "
            << patches.names() << exit(FatalIOError);
    }
    for (const word& name : own)
    {
        const label patchi = patches.findPatchID(name);
        if (patchi < 0)
        {
            FatalIOErrorInFunction(dict)
                << "outlet " << product << " names the patch " << name
                << ", allowed: " << patches.names() << exit(FatalIOError);
        }
        if (ofPatch_[patchi] >= 0)
        {
            FatalIOErrorInFunction(dict)
                << "outlet " << product << " names the patch " << name
                << ", which " << names_[ofPatch_[patchi]] << " has, allowed:"
                << " each patch once" << exit(FatalIOError);
        }
        ofPatch_[patchi] = names_.size() - 1;
    }
}


// * * * * * * * * * * * * * * * * Constructors  * * * * * * * * * * * * * * //

Products::Products(const dictionary& feed, const polyBoundaryMesh& patches)
:
    ofPatch_(patches.size(), -1)
{
    const dictionary& dict = feed.subDict("outlets");
    refuseRepeated(dict, feed);
    for (const entry& e : dict)
    {
        if (e.keyword() == "inside")
        {
            FatalIOErrorInFunction(dict)
                << "an outlet is named inside, allowed: another name: inside is"
                << " what has not left" << exit(FatalIOError);
        }
        names_.append(e.keyword());
        readPatches(dict, e.keyword(), patches);
    }
    if (names_.empty())
    {
        FatalIOErrorInFunction(dict)
            << "there is no outlet, allowed: NAME (patches); for each product"
            << exit(FatalIOError);
    }
    partitionTo_ = names_.last();
    for (const word& name : names_)
    {
        partitionTo_ = name == "other" ? partitionTo_ : name;
    }
    feed.readIfPresent("partitionTo", partitionTo_);
    if (std::find(names_.begin(), names_.end(), partitionTo_) == names_.end())
    {
        FatalIOErrorInFunction(feed)
            << "partitionTo is " << partitionTo_ << ", allowed: " << names_
            << exit(FatalIOError);
    }
}


} // End namespace Foam
