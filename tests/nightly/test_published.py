"""All numbers that others published, and the record of them."""

from validation import published, records


def test_all_published_numbers_are_ours_and_the_record_has_the_verdicts_of_today():
    compared = [
        (source, [published.compare(number) for number in source.numbers])
        for source in published.read_sources()
    ]
    assert [one for _, comparisons in compared for one in comparisons if not one.expected] == []
    assert published.summary(compared) in (records.FOLDER / "published.md").read_text()
