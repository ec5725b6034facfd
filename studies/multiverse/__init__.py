"""The multiverse: all that the article leaves open drawn at once, and every claim judged under every reading.

One folder: deleting it leaves a whole reproduction. Data flows `design` (what is drawn) -> `jobs` and `learning`
(files) -> `judging` (each setting) -> `shares`, `compatibility`, `adoption`, `prediction` (all settings) -> `figures`,
`page`.
"""
