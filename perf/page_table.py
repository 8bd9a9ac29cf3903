"""Puts a table that a script has made between its marks on a page: <!-- NAME:begin ... --> and <!-- NAME:end -->."""


def write_table(path, name, lines):
    with open(path, encoding="utf-8") as f:
        text = f.read()
    start = text.index("\n", text.index(f"<!-- {name}:begin")) + 1
    end = text.index(f"<!-- {name}:end -->")
    with open(path, "w", encoding="utf-8") as f:
        f.write(text[:start] + "\n" + "\n".join(lines) + "\n\n" + text[end:])
