/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "foam/fileEntries.H"
#include "foam/ownEntries.H"
#include "dictionary.H"
#include "DynamicList.H"
#include "IFstream.H"
#include "OStringStream.H"
#include "token.H"

#include <cstring>
#include <map>
#include <vector>

namespace Foam
{

namespace
{

//- An entry where it stands in a file
struct FileEntry
{
    std::string path;       // OUTER/INNER/NAME
    bool isDictionary, isConditional;
};


//- The format of a field's values, by the file's header
word formatOf(const fileName& path)
{
    IFstream file(path);
    token first;
    return
        file.good() && file.read(first).good()
     && first.isWord() && first.wordToken() == "FoamFile"
      ? dictionary(file).getOrDefault<word>("format", "ascii") : word("ascii");
}


//- Goes through a file's own text, without what it includes, and notes the
//  entries outside of lists
class Scan
{
    std::vector<FileEntry> entries_;

    //- The dictionaries around
    std::vector<std::string> around_;

    //- The entry that is being read; empty between two
    std::string key_;

    //- Is it more than its name so far?
    bool hasValue_ = false;

    //- Brackets open within its value, and #if around it
    label open_ = 0, conditions_ = 0;

    //- The line of a # that begins an entry: it is the directive's to its end
    label directive_ = -1;


    void note(const bool isDictionary)
    {
        std::string path;
        for (const std::string& name : around_)
        {
            path += name + '/';
        }
        if (!std::strchr("$({", key_[0]))   // a macro, a file that is a list
        {
            entries_.push_back({path + key_, isDictionary, conditions_ > 0});
        }
        key_.clear();
        hasValue_ = false;
    }

    void begin(const std::string& text, const label line)
    {
        if (text == "}")
        {
            if (!around_.empty())
            {
                around_.pop_back();
            }
        }
        else if (text[0] == '#')
        {
            directive_ = line;
            conditions_ += text.compare(0, 3, "#if") == 0;
            conditions_ -= text == "#endif";
        }
        else if (text != ";")
        {
            key_ = text;
            open_ = text == "(" || text == "{";
            hasValue_ = open_;
        }
    }

    void goOn(const std::string& text)
    {
        const bool opens = text == "{" || text == "(";
        const bool closes = text == "}" || text == ")";
        if (open_ > 0 || opens)
        {
            if (opens && open_ == 0 && !hasValue_ && text == "{")
            {
                const std::string name(key_);
                note(true);
                around_.push_back(name);
                return;
            }
            open_ += opens - closes;
            hasValue_ = true;
        }
        else if (text == ";" || closes)
        {
            note(false);
            if (closes)
            {
                begin(text, -1);
            }
        }
        else
        {
            hasValue_ = true;
        }
    }

    //- A field's values are one token, whose text says nothing
    static std::string textOf(const token& t)
    {
        if (t.isCompound())
        {
            return "values";
        }
        OStringStream written;
        written << t;
        return written.str();
    }

public:

    explicit Scan(const fileName& path)
    {
        IFstream file(path);
        file.format(formatOf(path));
        token t;
        while (file.good() && file.read(t).good() && t.good())
        {
            const std::string text(textOf(t));
            if (key_.empty() && t.lineNumber() != directive_)
            {
                begin(text, t.lineNumber());
            }
            else if (!key_.empty())
            {
                goOn(text);
            }
        }
    }

    const std::vector<FileEntry>& entries() const { return entries_; }
};

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

wordList topLevelKeys(const fileName& file)
{
    DynamicList<word> keys;
    const Scan scan(file);
    for (const FileEntry& e : scan.entries())
    {
        if (e.path.find('/') == std::string::npos)
        {
            keys.append(word(e.path, false));
        }
    }
    return wordList(std::move(keys));
}


wordList repeatedEntries(const fileName& file, const bool alsoMerged)
{
    std::map<std::string, std::vector<bool>> found;     // is it a dictionary?
    DynamicList<word> repeated;
    const Scan scan(file);
    for (const FileEntry& e : scan.entries())
    {
        if (e.isConditional)
        {
            continue;
        }
        std::vector<bool>& times = found[e.path];
        times.push_back(e.isDictionary);
        const bool merged = times == std::vector<bool>(2, true);
        if (times.size() == 2 && (alsoMerged || !merged))
        {
            repeated.append(word(e.path, false));
        }
    }
    return wordList(std::move(repeated));
}


} // End namespace Foam
