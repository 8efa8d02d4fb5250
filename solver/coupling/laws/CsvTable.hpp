// Tables that users write: a csv of numbers under a header.
#pragma once

#include <string>
#include <vector>

namespace elutria::laws
{

/// What throws, throws std::invalid_argument that says what is allowed.
class CsvTable
{
    std::string first_;
    std::vector<std::string> header_;
    struct Row { std::size_t line; std::vector<std::string> cells; };
    std::vector<Row> rows_;

public:

    /// Empty lines are left out. Columns that no one asks for may hold anything.
    explicit CsvTable(const std::string& csv);

    const std::vector<std::string>& header() const { return header_; }

    std::size_t size() const { return rows_.size(); }

    /// The number, from 0 on, in a row of a column; throws.
    double number(std::size_t row, int column) const;

    struct Column { int index; double unit; };      // unit: m

    /// The column of sizes: diameter_m, diameter_mm or diameter_um; throws.
    Column sizes() const;

    /// The column of a name; -1: none
    int find(const std::string& name) const;

    [[noreturn]] void refuseHeader(const std::string& allowed) const;
};

/// As short as a person writes it
std::string csvText(double value);

} // namespace elutria::laws
