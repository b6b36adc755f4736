"""News between the processes of a cloud."""

from engine.service.news import News


def test_news_reach_all_but_their_source_also_if_one_fails() -> None:
    def fail(kind: str, key: str) -> None:
        raise RuntimeError(key)

    news, first, second = News(), list[str](), list[str]()

    def source(kind: str, key: str) -> None:
        first.append(key)

    news.listen(fail)
    news.listen(source)
    news.listen(lambda kind, key: second.append(f"{kind} {key}"))
    news.tell("map", "office")
    news.tell("robot", "tb1", source=source)
    assert (first, second) == (["office"], ["map office", "robot tb1"])
