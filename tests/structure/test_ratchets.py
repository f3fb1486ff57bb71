"""The figures of the house that may only fall: ratchets.py counts, ratchets.toml holds."""

import pytest
import ratchets
import source_tree

HELD = ratchets.held_figures()


@pytest.fixture(scope="module")
def figures():
    return ratchets.all_figures()


# verifies: CMP-07
@pytest.mark.parametrize("name", sorted(HELD))
def test_a_figure_only_falls_and_is_lowered_when_it_has(figures, name):
    wrong = ratchets.complaint(name, figures.get(name, ratchets.counted([])), HELD[name])
    assert not wrong, wrong


def test_every_figure_is_held(figures):
    wrong = [ratchets.complaint(name, figure, 0) for name, figure in figures.items() if name not in HELD]
    assert not wrong, "\n".join(wrong)


ONE = """\
#include "map/two.hpp"
struct Wide {
  int a, b, c, d = 0;
  std::array<double, 3> e{};
  int f, g, h, i, j, k, l, m, n, o, p;
  bool sound() const { return a < b; }
  bool operator==(const Wide&) const = default;
  static constexpr int kHere = 1;  // chosen, and two lines
                                   // are one comment
};
// Chosen is this, too.
constexpr auto kText = "chosen 3";
void change(int times, Component::State* state) { state->clear(); }

void look(const Component::State& state, std::map<int, int> a, int b, int c, int d) {}
void mix(std::map<int, int> a, int (*b)(int, int), int c, int d, int e, State& f) { POLHODE_ASSERT(c == d && e <= 1, c); }
void keep(List* to) { POLHODE_ASSERT(to->push_back(1), 1); }
"""
TREE = {
    "fsw/map/one.hpp": ONE,
    "fsw/map/two.hpp": "",
    "fsw/map/two.cpp": '#include "map/two.hpp"\n#include "map/one.hpp"\n',
    "fsw/map/generated.hpp": f"{source_tree.WRITTEN_BY}\nconstexpr int kChosen = 1;  // chosen\n",
    "hil/judge/run.py": "import json\n\ndef f():\n    from . import row\n",
    "hil/judge/row.py": "from judge import run  # no" + "qa\nimport sys\nsys" + ".path[:0] = []\n",
    "docs/one.md": "# Three words\n\n- more\n",
    "tools/run.py": "from judge import run\n",
}


def test_each_figure_is_counted(tmp_path, monkeypatch):
    for module in (ratchets, source_tree):
        monkeypatch.setattr(module, "REPOSITORY", tmp_path)
    monkeypatch.setattr(ratchets, "HELD", tmp_path / "ratchets.toml")
    for name, text in TREE.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    figures = ratchets.all_figures()
    assert {name: figure.number for name, figure in figures.items()} == {
        "whole_state_functions": 2, "many_parameter_functions": 1, "chosen_comments": 2, "fsw_code_lines": 16, "include_cycles": 1,
        "assertions_with_effects": 1, "import_cycles": 1, "search_path_lines": 1, "silenced_lines": 1, "documents": 1, "hundreds_of_words": 1, "wide_structs.Wide": 16, "constants.map": 1}
    assert ratchets.complaint("constants.map", figures["constants.map"], 1) == ""
    assert ratchets.complaint("constants.map", figures["constants.map"], 0) == "constants.map is 1, held at 0:\nfsw/map/one.hpp:8: kHere"
    assert ratchets.complaint("constants.map", figures["constants.map"], 2).endswith("lower the figure in ratchets.toml to 1, now 2")
