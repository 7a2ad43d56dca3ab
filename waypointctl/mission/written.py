"""Where a file says something that is known by its place in the model."""

from __future__ import annotations

from waypointctl.mission.wording import path_text
from waypointctl.mission.yaml_tree import DataPath, Mark, Tree
from waypointctl.units import bare_name


def written_at(tree: Tree, path: DataPath) -> tuple[str, Mark]:
    """Return a place in a model as the file writes it, and where; of what is left to a default the part around it.

    What is written nowhere goes by its bare name.

    Args:
        tree: of the file.
        path: by the fields' names; a key may be written without its unit, and what is for each way of a link once.
    """
    written: DataPath = ()
    for part in path:
        names = (part, bare_name(part)) if isinstance(part, str) else (part,)
        found = next((name for name in names if name is not None and (*written, name) in tree.values), None)
        if found is not None:
            written = (*written, found)
        elif part not in ("up", "down"):
            break
    mark = tree.keys.get(written) or tree.values.get(written)
    bare = [(bare_name(part) or part) if isinstance(part, str) else part for part in path]
    return path_text(written) or path_text(bare), mark or Mark(1, 1)
