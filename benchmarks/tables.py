"""Tables in Markdown, as the benchmarks print them."""


def begin(text, head):
    """Print the first paragraph of a benchmark's docstring and a table's head, columns by bars."""
    print(text.split("\n\n")[0].strip() + "\n")
    print(f"| {head} |")
    print("|---" * (head.count("|") + 1) + "|")
