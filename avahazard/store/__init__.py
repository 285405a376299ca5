"""The database: tables, sessions, repositories; the only place with SQL."""
