/*---------------------------------------------------------------------------*\
    Elutria: gravitational air classification with OpenFOAM

    Copyright (C) 2026 The Elutria developers
    SPDX-License-Identifier: GPL-3.0-or-later
\*---------------------------------------------------------------------------*/

#include "run/caseDictionaries.H"
#include "run/caseFiles.H"
#include "run/NothingExecuted.H"
#include "run/exitHandling.H"
#include "foam/Json.H"
#include "foam/fileEntries.H"
#include "foam/honoured.H"
#include "foam/ownEntries.H"
#include "IFstream.H"
#include "OStringStream.H"
#include "OSspecific.H"

#include <limits>

namespace Foam
{

namespace
{

std::string asJson(const dictionary&);


//- With as many digits as give the same number back
std::string asJson(const scalar value)
{
    std::ostringstream text;
    for (const int digits : {15, 17})
    {
        text.str("");
        text << std::setprecision(digits) << value;
        if (!(std::abs(value) <= std::numeric_limits<scalar>::max()))
        {
            return json::text(text.str());
        }
        if (std::stod(text.str()) == value)
        {
            break;
        }
    }
    return text.str();
}


//- The tokens of an entry, one value after another
class Values
{
    const UList<token>& tokens_;
    label at_ = 0;

    bool isNext(const token::punctuationToken mark, const label ahead = 0) const
    {
        const label k = at_ + ahead;
        return
            k < tokens_.size() && tokens_[k].isPunctuation()
         && tokens_[k].pToken() == mark;
    }

    //- Values up to a closing bracket, behind the opening one
    std::string listUntil(const token::punctuationToken end)
    {
        std::vector<std::string> values;
        ++at_;
        while (at_ < tokens_.size() && !isNext(end))
        {
            values.push_back(value());
        }
        ++at_;
        return json::list(values);
    }

    //- A dictionary within a list, behind its opening bracket
    std::string dictionaryHere()
    {
        std::vector<std::string> entries;
        ++at_;
        while (at_ < tokens_.size() && !isNext(token::END_BLOCK))
        {
            const std::string key(name());
            if (isNext(token::BEGIN_BLOCK))
            {
                entries.push_back(key + ": " + dictionaryHere());
                continue;
            }
            entries.push_back(key + ": " + valueUntil(token::END_STATEMENT));
            ++at_;
        }
        ++at_;
        return joined(entries);
    }

    //- The token at hand as a name
    std::string name()
    {
        OStringStream text;
        text << tokens_[at_++];
        return json::text(text.str());
    }

    //- One value
    std::string value()
    {
        const token& t = tokens_[at_];
        if (isNext(token::BEGIN_LIST))
        {
            return listUntil(token::END_LIST);
        }
        if (isNext(token::BEGIN_SQR))
        {
            return "{\"[]\": " + listUntil(token::END_SQR) + '}';
        }
        if (isNext(token::BEGIN_BLOCK))
        {
            return dictionaryHere();
        }
        if (at_ == 0 && t.isLabel() && isNext(token::BEGIN_LIST, 1))
        {
            ++at_;      // a list's length, before it
            return listUntil(token::END_LIST);
        }
        if (t.isWord() && isNext(token::BEGIN_BLOCK, 1))
        {
            const std::string key(name());
            return "{\"{}\": [" + key + ", " + dictionaryHere() + "]}";
        }
        if (t.isNumber())
        {
            ++at_;
            return
                t.isLabel() ? std::to_string(t.labelToken())
              : asJson(t.number());
        }
        return name();
    }

public:

    explicit Values(const UList<token>& tokens) : tokens_(tokens) {}

    static std::string joined(const std::vector<std::string>& entries)
    {
        std::string all(json::list(entries));
        all.front() = '{';
        all.back() = '}';
        return all;
    }

    //- The single value up to a mark, or the list of several
    std::string valueUntil(const token::punctuationToken end)
    {
        std::vector<std::string> values;
        while (at_ < tokens_.size() && !isNext(end))
        {
            values.push_back(value());
        }
        return values.size() == 1 ? values[0] : json::list(values);
    }
};


std::string asJson(const dictionary& dict)
{
    std::vector<std::string> entries;
    for (const entry& e : dict)
    {
        const std::string key(e.keyword());
        entries.push_back
        (
            json::text(e.keyword().isPattern() ? '"' + key + '"' : key) + ": "
          + (
                e.isDict() ? asJson(e.dict())
              : Values(e.stream()).valueUntil(token::NULL_TOKEN)
            )
        );
    }
    return Values::joined(entries);
}


std::string asJson(const wordList& names)
{
    std::vector<std::string> all;
    for (const word& name : names)
    {
        all.push_back(json::text(name));
    }
    return json::list(all);
}


//- What is known of a file; empty where it is no dictionary
std::string fileAsJson(const fileName& file)
{
    const auto refused = [](const std::string& why)
    {
        return "{\"error\": " + json::text(why) + '}';
    };
    try
    {
        caseFiles::refuseHugeDictionary(file);
        IFstream is(file);
        const dictionary dict(is);
        return
            "{\"entries\": " + asJson(dict)
          + ", \"own\": " + asJson(topLevelKeys(file))
          + ", \"repeated\": " + asJson(repeatedEntries(file, true))
          + ", \"included\": " + asJson(includedFiles(file)) + '}';
    }
    catch (const IOerror& error)
    {
        return refused(exitHandling::described(error));
    }
    catch (const error& error)
    {
        return refused(error.message());
    }
}


//- May the file be a dictionary?
bool isText(const fileName& root, const word& name)
{
    const honoured::Item* const item =
        honoured::find(honoured::kind::file, name);
    const bool shape =
        item && item->is == honoured::use::others
     && name.compare(0, 9, "constant/") == 0;
    return isFile(root/name, false) && !shape;
}

} // End anonymous namespace


// * * * * * * * * * * * * * * * Global Functions  * * * * * * * * * * * * * //

std::string dictionariesAsJson(const fileName& root)
{
    const NothingExecuted whileReading;
    std::vector<std::string> files;
    for (const char* const folder : {"constant", "system"})
    {
        for (const word& name : caseFiles::filesOf(root, folder))
        {
            if (isText(root, name))
            {
                files.push_back(json::text(name) + ": " + fileAsJson(root/name));
            }
        }
    }
    return Values::joined(files);
}


} // End namespace Foam
