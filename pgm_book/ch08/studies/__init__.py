"""The seeded scripts behind the tables in results/ of this chapter."""
