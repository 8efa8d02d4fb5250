#include "CsvTable.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <sstream>
#include <stdexcept>

namespace elutria::laws
{

namespace
{

std::vector<std::string> cells(const std::string& line)
{
    std::vector<std::string> found;
    std::istringstream stream(line + ',');
    for (std::string cell; std::getline(stream, cell, ',');)
    {
        const auto first = cell.find_first_not_of(" \t\r\""), last = cell.find_last_not_of(" \t\r\"");
        found.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    }
    return found;
}

} // namespace


CsvTable::CsvTable(const std::string& csv)
{
    const std::string mark = "\xEF\xBB\xBF";      // of UTF-8, as spreadsheets write it
    std::istringstream stream(csv.rfind(mark, 0) == 0 ? csv.substr(mark.size()) : csv);
    std::getline(stream, first_);
    header_ = cells(first_);

    std::string line;
    for (std::size_t row = 2; std::getline(stream, line); ++row)
    {
        const std::vector<std::string> own = cells(line);
        if (std::all_of(own.begin(), own.end(), [](const std::string& c) { return c.empty(); })) continue;
        if (own.size() != header_.size())
            throw std::invalid_argument("line " + std::to_string(row) + " has "
                                        + std::to_string(own.size()) + " columns, allowed: "
                                        + std::to_string(header_.size()));
        rows_.push_back({row, own});
    }
}


CsvTable::Column CsvTable::sizes() const
{
    Column found{-1, 1};
    for (const Column& column : {Column{find("diameter_m"), 1}, Column{find("diameter_mm"), 1e-3},
                                 Column{find("diameter_um"), 1e-6}})
        if (column.index >= 0)
        {
            if (found.index >= 0) refuseHeader("one column of sizes");
            found = column;
        }
    if (found.index < 0) refuseHeader("one of diameter_m, diameter_mm, diameter_um");
    return found;
}


double CsvTable::number(std::size_t row, int column) const
{
    const std::string& cell = rows_[row].cells[column];
    std::size_t end = 0;
    double value = 0;
    try
    {
        value = std::stod(cell, &end);
    }
    catch (const std::exception&)
    {}
    if (end == 0 || end != cell.size() || !(value >= 0) || !std::isfinite(value))
        throw std::invalid_argument("line " + std::to_string(rows_[row].line) + " has '" + cell
                                    + "', allowed: a number >= 0");
    return value;
}


int CsvTable::find(const std::string& name) const
{
    for (std::size_t k = 0; k < header_.size(); ++k)
        if (header_[k] == name) return int(k);
    return -1;
}


void CsvTable::refuseHeader(const std::string& allowed) const
{
    throw std::invalid_argument("the first line is '" + first_ + "', allowed: " + allowed);
}


std::string csvText(double value)
{
    std::ostringstream stream;
    stream << value;
    return stream.str();
}

} // namespace elutria::laws
